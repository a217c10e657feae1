"""What cameras measure: judged by the pinhole, the lens and the geometry in front of them."""

import itertools
import math
from collections.abc import Iterator

import mujoco
import numpy as np
import pytest

from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces import get_message
from teleopctl.mujoco_model import CameraModel
from teleopctl.mujoco_model.model import RobotModel, build_model
from teleopctl.pictures import depths_of
from teleopctl.sim.cameras import renderer as quality
from teleopctl.sim.cameras.lens import camera_projection, distorted
from teleopctl.sim.cameras.messages import Rectifier, compress_depths, new_compressed, new_points
from teleopctl.sim.cameras.model_topic import model_from_message
from teleopctl.sim.cameras.renderer import CameraRenderer
from tests.samples import sample
from tests.sim.robots import box, joint, link, robot

WIDTH, HEIGHT, FOV = 320, 240, 1.2
LENS = (-0.25, 0.08, 0.002, -0.003, -0.01)
# Plates of 0.1 m: x forward, y left, z up of the eye, in metres.
MARKERS = {"a": (3.0, 1.2, 0.9), "b": (4.0, -2.0, -1.2), "c": (2.5, -0.9, 0.8), "d": (5.0, 0, 0)}
SIDE, THICK = 0.1, 0.002


def eye(name: str, kind: str, inside: str = "", beside: str = "") -> str:
    return f"""<gazebo reference="eye"><sensor name="{name}" type="{kind}"><camera name="{name}">
      <horizontal_fov>{FOV}</horizontal_fov><clip><near>0.05</near><far>6</far></clip>
      <image><width>{WIDTH}</width><height>{HEIGHT}</height></image>{inside}</camera>{beside}
      </sensor></gazebo>"""


def lens(k1: float, k2: float, p1: float, p2: float, k3: float) -> str:
    named = {"k1": k1, "k2": k2, "p1": p1, "p2": p2, "k3": k3}
    return f"<distortion>{''.join(f'<{n}>{v}</{n}>' for n, v in named.items())}</distortion>"


INTRINSICS = """<lens><intrinsics><fx>200</fx><fy>240</fy><cx>150</cx><cy>130</cy></intrinsics>
  </lens>"""


@pytest.fixture(scope="module")
def scene() -> RobotModel:
    """Red markers in front of three cameras 8 m above the ground."""
    parts = []
    for name, (x, y, z) in MARKERS.items():
        # The middle of its front is where the marker is.
        parts.append(link(name, box("visual", f"{THICK} {SIDE} {SIDE}")))
        place = f"{x + THICK / 2} {y} {z}"
        parts.append(joint(f"to_{name}", "eye", name, kind="fixed", xyz=place))
        parts.append(f'<gazebo reference="{name}"><material>Gazebo/Red</material></gazebo>')
    return build_model(
        robot(
            link("world", ""),
            link("eye", ""),
            joint("mount", "world", "eye", kind="fixed", xyz="0 0 8"),
            *parts,
            eye("plain", "rgbd_camera"),
            eye("bent", "rgbd_camera", lens(*LENS)),
            eye("odd", "rgbd_camera", INTRINSICS),
            eye("names", "segmentation_camera"),
        )
    )


@pytest.fixture(scope="module")
def renderer(scene: RobotModel) -> Iterator[CameraRenderer]:
    made = CameraRenderer(scene, scene.cameras, quality.FULL)
    made.place({})
    yield made
    made.close()


def test_a_model_that_is_none_or_another_robots_is_refused_in_words(scene: RobotModel) -> None:
    """Whatever bytes somebody sends: what they ask for may be more than there is."""
    size = mujoco.mj_sizeModel(scene.mj_model)
    whole = np.zeros(size, np.uint8)
    mujoco.mj_saveModel(scene.mj_model, None, whole)
    message = get_message("std_msgs/msg/UInt8MultiArray")
    assert model_from_message(message(data=whole), scene).mj_model.nbody == scene.mj_model.nbody
    assert model_from_message(message(), scene) is scene

    other = mujoco.MjModel.from_xml_string("<mujoco/>")
    foreign = np.zeros(mujoco.mj_sizeModel(other), np.uint8)
    mujoco.mj_saveModel(other, None, foreign)
    arena = np.frombuffer(int(scene.mj_model.narena).to_bytes(8, "little"), np.uint8)
    (places,) = np.nonzero(np.all(np.lib.stride_tricks.sliding_window_view(whole, 8) == arena, 1))
    greedy = whole.copy()
    greedy[places[0] + 7] = 0x20
    for wrong in (greedy, foreign, whole[: size // 2], np.zeros(4000, np.uint8)):
        with pytest.raises(InvalidMessageError):
            model_from_message(message(data=wrong), scene)


def centres(picture: np.ndarray) -> list[tuple[float, float]]:
    """Column and row of each red patch."""
    picture = picture.astype(int)
    rows, columns = np.nonzero(picture[..., 0] > 60 + picture[..., 1:].max(axis=-1))
    groups: list[list[tuple[int, int]]] = []
    for point in zip(columns.tolist(), rows.tolist(), strict=True):
        near = [g for g in groups if any(math.dist(point, other) < 3 for other in g)]
        groups = [g for g in groups if g not in near] + [[point, *itertools.chain(*near)]]
    means = [np.mean(group, axis=0) for group in groups]
    return [(float(column), float(row)) for column, row in means]


def projected(camera: CameraModel, place: tuple[float, float, float]) -> tuple[float, float]:
    """The pixel in which the middle of a marker's front is seen."""
    x, y, z = place
    fx, _, cx, _, fy, cy, *_ = camera.intrinsics
    at_x, at_y = distorted(np.array(-y / x), np.array(-z / x), camera.distortion)
    return fx * float(at_x) + cx, fy * float(at_y) + cy


@pytest.mark.parametrize(
    ("name", "within"), sample([("plain", 1.0), ("bent", 1.5), ("odd", 1.0)], 2)
)
def test_a_marker_appears_where_camera_info_says(
    scene: RobotModel, renderer: CameraRenderer, name: str, within: float
) -> None:
    picture = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    renderer.colours(name, picture)
    found = centres(picture)

    assert len(found) == len(MARKERS)
    for place in MARKERS.values():
        wanted = projected(scene.camera(name), place)
        assert min(math.dist(wanted, centre) for centre in found) < within
    if name == "bent":
        straight = projected(scene.camera("plain"), MARKERS["b"])
        assert math.dist(straight, projected(scene.camera(name), MARKERS["b"])) > 8


@pytest.mark.parametrize("name", ["plain", "bent"])
def test_depths_and_points_are_true_to_a_millimetre(
    scene: RobotModel, renderer: CameraRenderer, name: str
) -> None:
    camera = scene.camera(name)
    picture = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    depths = renderer.colours_and_depths(name, picture)
    cloud = new_points(camera)
    Rectifier(camera).fill(cloud, depths, picture)
    points = np.frombuffer(cloud.data, np.float32).reshape(HEIGHT, WIDTH, 4)

    for x, y, z in MARKERS.values():
        column, row = (round(value) for value in projected(camera, (x, y, z)))
        assert depths[row, column] == pytest.approx(x, abs=1e-3)
        # REP 103: x right, y down, z forward; a pixel is up to 0.8 cm wide there.
        assert points[row, column, :3] == pytest.approx((-y, -z, x), abs=0.02)
        colour = points.view(np.uint8)[row, column, 12:15]
        assert colour[2] > 60 + max(colour[:2]), "red is the third byte"
    # The sky, and the ground below, which is beyond the far plane.
    assert np.isinf(depths[5, WIDTH // 2]) and np.isinf(depths[-5, WIDTH // 2])
    assert np.isnan(points[5, WIDTH // 2, :3]).all()


def test_the_sky_is_drawn_behind_the_far_plane(renderer: CameraRenderer) -> None:
    picture = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    renderer.colours("plain", picture)

    red, _, blue = picture[5, WIDTH // 2].astype(int)
    assert blue > red + 10 and blue > 120


def test_labels_are_the_numbers_of_bodies(scene: RobotModel, renderer: CameraRenderer) -> None:
    labels = renderer.labels("names")

    for name, place in MARKERS.items():
        column, row = (round(value) for value in projected(scene.camera("names"), place))
        assert labels[row, column] == scene.mj_model.body(name).id
    assert labels[5, WIDTH // 2] == 0
    assert set(np.unique(labels)) == {0} | {scene.mj_model.body(name).id for name in MARKERS}


@pytest.mark.parametrize(
    "lens_", [LENS, (0.3, 0.1, 0, 0, 0), (0, 0, 0.01, 0.02, 0), (-0.9, 0, 0, 0, 0)]
)
def test_each_pixel_of_a_lens_is_taken_from_where_the_lens_puts_it(
    lens_: tuple[float, float, float, float, float],
) -> None:
    camera = CameraModel("c", "l", "f", 200, 150, 1.4, 30.0, distortion=lens_)
    view = camera_projection(camera)
    assert view.pixels is not None
    seen = view.pixels < view.width * view.height
    row, column = np.divmod(view.pixels[seen], view.width)
    x = view.left + (column + 0.5) / view.width * (view.right - view.left)
    y = -view.top + (row + 0.5) / view.height * (view.top - view.bottom)
    fx, _, cx, _, fy, cy, *_ = camera.intrinsics
    at_x, at_y = distorted(x, y, lens_)
    rows, columns = np.divmod(np.flatnonzero(seen), camera.width)

    # The nearest drawn pixel is half a pixel away at most, and a lens may stretch that.
    assert np.hypot(fx * at_x + cx - columns, fy * at_y + cy - rows).max() < 1.5
    assert seen.reshape(150, 200)[50:100, 60:140].all()


def test_compressed_depths_are_read_by_who_reads_image_transports() -> None:
    camera = CameraModel("c", "l", "f", 3, 2, 1.0, 30.0)
    depths = np.array([[0.5, 1.0, 2.0], [5.0, np.inf, -np.inf]], np.float32)
    message = new_compressed(camera)
    compress_depths(message, depths)
    read = depths_of(message)

    assert message.format == "32FC1; compressedDepth png"
    assert read[0] == pytest.approx(depths[0], abs=1e-3)
    assert read[1, 0] == pytest.approx(5.0, abs=3e-3)
    assert list(read[1, 1:]) == [0, 0]


def topics(*sensors: str) -> list[dict[str, str]]:
    return [dict(c.topics) for c in build_model(robot(link("eye", ""), *sensors)).cameras]


def plugin(content: str) -> str:
    return f'<plugin name="p" filename="libgazebo_ros_camera.so">{content}</plugin>'


def test_cameras_without_a_word_on_topics_have_names_unless_they_are_alone() -> None:
    assert topics(eye("a", "camera")) == [{"image": "image_raw", "info": "camera_info"}]
    both = topics(eye("a", "camera"), eye("b", "camera"))
    assert [camera["image"] for camera in both] == ["a/image_raw", "b/image_raw"]


@pytest.mark.parametrize(
    ("sensor", "wanted"),
    [
        (eye("a", "camera", beside="<topic>front/image</topic>"),
         {"image": "front/image", "info": "front/camera_info"}),
        (eye("a", "camera", "<camera_info_topic>i</camera_info_topic>", "<topic>im</topic>"),
         {"image": "im", "info": "i"}),
        (eye("a", "rgbd_camera", beside="<topic>/front</topic>"),
         {"image": "/front/image", "depth": "/front/depth_image", "points": "/front/points",
          "info": "/front/camera_info"}),
        (eye("a", "camera", beside=plugin("")),
         {"image": "a/image_raw", "info": "a/camera_info"}),
        (eye("a", "camera", beside=plugin("<ros><namespace>/r</namespace><remapping>"
             "~/image_raw:=front</remapping></ros><camera_name>c</camera_name>")),
         {"image": "/r/front", "info": "/r/c/camera_info"}),
        # A plug-in of ROS 1, which a description for Gazebo still has beside the topic.
        (eye("a", "camera", beside=f"<topic>/s/im</topic>{plugin('<cameraName>c</cameraName>')}"),
         {"image": "/s/im", "info": "/s/camera_info"}),
        (eye("a", "depth", beside=plugin("<ros><remapping>/a/image_raw:=/a/color/image_raw"
             "</remapping><remapping>/a/points:=cloud</remapping></ros>")),
         {"image": "/a/color/image_raw", "info": "a/camera_info", "depth": "a/depth/image_raw",
          "depth_info": "a/depth/camera_info", "points": "cloud"}),
    ],
)  # fmt: skip
def test_topics_are_those_of_gazebo(sensor: str, wanted: dict[str, str]) -> None:
    assert topics(sensor) == [wanted]


def test_a_cameras_name_that_is_no_topic_in_ros_is_told_and_made_one() -> None:
    built = build_model(robot(link("eye", ""), eye("cam-1", "camera"), eye("b", "camera")))

    assert built.camera("cam-1").topics["image"] == "cam_1/image_raw"
    told = (
        "'cam-1/image_raw' is not a valid topic name: camera 'cam-1' publishes on 'cam_1/image_raw'"
    )
    assert told in built.warnings


def test_the_projection_is_shifted_as_the_description_says() -> None:
    baseline = '<plugin name="p" filename="libgazebo_ros_camera.so"><hack_baseline>0.2'
    said = "<p_fx>9</p_fx><p_fy>8</p_fy><p_cx>7</p_cx><p_cy>6</p_cy><tx>5</tx><ty>4</ty>"
    cameras = build_model(
        robot(
            link("eye", ""),
            eye("pair", "camera", beside=f"{baseline}</hack_baseline></plugin>"),
            eye("said", "camera", f"<lens><projection>{said}</projection></lens>"),
            eye("alone", "camera"),
        )
    ).cameras
    focal = WIDTH / 2 / math.tan(FOV / 2)
    shifts = {camera.name: camera.projection[3::4] for camera in cameras}
    assert shifts["pair"] == pytest.approx((-0.2 * focal, 0.0, 0.0))
    assert shifts["alone"] == (0.0, 0.0, 0.0)
    (chosen,) = (camera for camera in cameras if camera.name == "said")
    assert chosen.projection == (9, 0, 7, 5, 0, 8, 6, 4, 0, 0, 1, 0)
