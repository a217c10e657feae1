"""Boxes around what a camera sees: judged by the pinhole and by what stands in front."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from teleopctl.interfaces import get_message
from teleopctl.mujoco_model.model import RobotModel, build_model
from teleopctl.sim.cameras import renderer as quality
from teleopctl.sim.cameras.messages import draw_boxes, fill_boxes, label_boxes, new_boxes
from teleopctl.sim.cameras.renderer import CameraRenderer
from tests.sim.robots import box, joint, link, robot

WIDTH, HEIGHT, FOV = 320, 240, 1.2


def camera(inside: str = "", beside: str = "") -> str:
    return f"""<gazebo reference="eye"><sensor name="boxes" type="boundingbox_camera"><camera>
      <horizontal_fov>{FOV}</horizontal_fov><image><width>{WIDTH}</width><height>{HEIGHT}</height>
      </image>{inside}</camera>{beside}</sensor></gazebo>"""


def built(*sensors: str) -> RobotModel:
    """A plate 0.4 m wide at 3 m, half of which another one covers; nothing of a third is seen."""
    places = {"plate": "3.001 0.5 0.3", "cover": "2 0.2 0.2", "hidden": "4 0.8 0.5"}
    sizes = {"plate": "0.002 0.4 0.2", "cover": "0.002 0.2 0.4", "hidden": "0.1 0.1 0.02"}
    parts = [
        link(name, box("visual", sizes[name]))
        + joint(f"to_{name}", "eye", name, kind="fixed", xyz=place)
        for name, place in places.items()
    ]
    mount = joint("mount", "world", "eye", kind="fixed", xyz="0 0 8")
    return build_model(robot(link("world", ""), link("eye", ""), mount, *parts, *sensors))


@pytest.fixture(scope="module")
def scene() -> RobotModel:
    return built(camera(beside="<topic>eyes/boxes</topic>"))


@pytest.fixture(scope="module")
def labels(scene: RobotModel) -> Iterator[np.ndarray]:
    renderer = CameraRenderer(scene, scene.cameras, quality.FULL)
    renderer.place({})
    yield renderer.labels("boxes")
    renderer.close()


def detections(scene: RobotModel, labels: np.ndarray) -> dict[str, Any]:
    message = new_boxes("eye_optical")
    fill_boxes(message, list(label_boxes(labels)))
    names = [scene.mj_model.body(number).name for number in range(scene.mj_model.nbody)]
    return {names[int(d.results[0].hypothesis.class_id)]: d for d in message.detections}


def test_each_body_has_a_box_around_what_is_seen_of_it(
    scene: RobotModel, labels: np.ndarray
) -> None:
    found = detections(scene, labels)
    focal = WIDTH / 2 / math.tan(FOV / 2)

    assert found.keys() == {"plate", "cover", "ground_plane"}
    cover = found["cover"].bbox
    centre = cover.center.position.x, cover.center.position.y
    wanted = ((WIDTH - 1) / 2 - focal * 0.1, (HEIGHT - 1) / 2 - focal * 0.1)
    assert centre == pytest.approx(wanted, abs=1.0)
    assert (cover.size_x, cover.size_y) == pytest.approx((focal * 0.1, focal * 0.2), abs=1.5)
    # The plate's right edge is behind the cover's left one: at y = 0.3 in 2 m is 0.45 in 3 m.
    plate = found["plate"].bbox
    assert plate.size_x == pytest.approx(focal * (0.7 - 0.45) / 3, abs=1.5)
    assert found["plate"].results[0].hypothesis.score == 1.0


def test_boxes_are_drawn_into_the_picture_of_them(labels: np.ndarray) -> None:
    picture = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    boxes = list(label_boxes(labels))
    draw_boxes(picture, boxes)

    for _, left, top, right, bottom in boxes:
        for row, column in ((top, left), (bottom, right), (top, (left + right) // 2)):
            assert tuple(picture[row, column]) == (0, 255, 0)
    assert not picture[5, 5].any()


def test_topics_and_messages_are_those_that_ros_gz_passes_on(scene: RobotModel) -> None:
    assert dict(scene.camera("boxes").topics) == {
        "boxes": "eyes/boxes",
        "boxed_image": "eyes/boxes_image",
        "info": "eyes/camera_info",
    }
    assert type(new_boxes("a")) is get_message("vision_msgs/msg/Detection2DArray")


@pytest.mark.parametrize("kind", ["full_2d", "3d"])
def test_boxes_around_what_is_not_seen_are_told(kind: str) -> None:
    model = built(camera(f"<box_type>{kind}</box_type>"))

    assert model.cameras == ()
    assert f"its <box_type> is '{kind}'" in " ".join(model.warnings)
