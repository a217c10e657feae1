"""The camera as a process, fed by the simulator."""

import itertools
import os
import sys
import threading
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from teleopctl.interfaces.store import get_message, get_service
from teleopctl.node import Context, Node, init, qos_profile_latched
from teleopctl.nodes.camera import CameraNode
from teleopctl.testing import LONGEST_WAIT_S, Process, RosGraph
from tests.system.sim_partner import Partner, command, stamp_ns, teleop_urdf

Image = get_message("sensor_msgs/msg/Image")
CameraInfo = get_message("sensor_msgs/msg/CameraInfo")

_KEPT = 4

# The gripper comes down in front of the camera.
IN_VIEW = {"joint_1": 0.1, "joint_2": -0.7, "joint_3": -0.2, "joint_4": -0.5}


class Viewer(Node):
    """Subscribes to what the camera offers."""

    def __init__(self) -> None:
        self._own = Context()
        self._own.init(args=[])
        super().__init__("viewer", context=self._own, start_parameter_services=False)
        self.images: list = []
        self.infos: list = []
        self._changed = threading.Condition()

    def look(self) -> None:
        self._images = self.create_subscription(
            Image, "/image_raw", self._collect(self.images), 1, immediate=True
        )

    def look_away(self) -> None:
        self.destroy_subscription(self._images)

    def read_info(self) -> None:
        self.create_subscription(
            CameraInfo, "/camera_info", self._collect(self.infos), 10, immediate=True
        )

    def collect(self, kind: str, topic: str, messages: list, qos: Any = 1) -> None:
        self.create_subscription(
            get_message(kind), topic, self._collect(messages), qos, immediate=True
        )

    def wait(self, what) -> None:
        with self._changed:
            assert self._changed.wait_for(what, LONGEST_WAIT_S)

    def close(self) -> None:
        self._own.try_shutdown()

    def _collect(self, messages: list):
        def keep(message) -> None:
            with self._changed:
                messages.append(message)
                # A picture holds 9 MB.
                del messages[:-_KEPT]
                self._changed.notify_all()

        return keep


@pytest.fixture
def partner(ros: RosGraph) -> Iterator[Partner]:
    node = Partner(teleop_urdf())
    yield node
    node.close()


@pytest.fixture
def viewer(ros: RosGraph) -> Iterator[Viewer]:
    node = Viewer()
    yield node
    node.close()


@pytest.fixture
def camera(ros: RosGraph, partner: Partner) -> Process:
    sim = ros.spawn_module("teleopctl.nodes", ["mujoco_sim", "mujoco_sim"])
    process = ros.spawn_module(
        "teleopctl.nodes", ["camera", "camera", "--ros-args", "-p", "quality:=fast"]
    )
    process.wait_for_line("Camera 'rgb_camera': 2304x1296 at 30 Hz")
    sim.wait_for_line("Simulation is running")
    return process


def pixels(image) -> np.ndarray:
    return np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, 3)


def test_an_image_shows_the_arm_lit_and_the_right_way_up(
    camera: Process, partner: Partner, viewer: Viewer
) -> None:
    partner.connect(lambda state: command(state, **IN_VIEW))
    partner.wait(lambda: abs(partner.states[-1].position[1] + 0.7) < 1e-6 if partner.states else 0)
    moment = stamp_ns(partner.states[-1])

    viewer.look()
    viewer.wait(lambda: bool(viewer.images) and stamp_ns(viewer.images[-1]) > moment)

    image = viewer.images[-1]
    assert (image.width, image.height, image.step) == (2304, 1296, 3 * 2304)
    assert (image.encoding, image.header.frame_id) == ("rgb8", "rgb_camera_optical")
    picture = pixels(image).astype(int)
    sky, ground = picture[100, -100], picture[-100, -100]
    assert sky[2] > sky[0] + 10, "the sky is blue and above"
    assert abs(ground[2] - ground[0]) < 20, "the ground is grey and below"
    red, green, blue = np.moveaxis(picture, -1, 0)
    teal = (green > red + 40) & (blue > red + 40) & (red < 60)
    assert teal.mean() > 0.02, "the fingers are in view"
    assert picture[teal].max() > 120, "and lit"


CUBE_AND_EYE = """<robot name="scene"><link name="world"/><link name="eye"/>
<joint name="mount" type="fixed"><parent link="world"/><child link="eye"/>
  <origin xyz="0 0 0.5"/></joint>
<gazebo reference="eye"><sensor name="eye" type="camera"><update_rate>10</update_rate>
  <camera name="eye"><horizontal_fov>1.2</horizontal_fov>
  <image><width>160</width><height>120</height></image></camera></sensor></gazebo>
<link name="cube"><inertial><mass value="1"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  <visual><geometry><box size="0.4 0.4 0.4"/></geometry></visual>
  <collision><geometry><box size="0.4 0.4 0.4"/></geometry></collision></link>
<gazebo reference="cube"><material>Gazebo/Red</material></gazebo>
<joint name="free" type="floating"><parent link="world"/><child link="cube"/>
  <origin xyz="3 0.6 0.2"/></joint></robot>"""


@pytest.mark.nightly
def test_a_free_body_is_seen_where_it_lies(ros: RosGraph, viewer: Viewer) -> None:
    partner = Partner(CUBE_AND_EYE)
    sim = ros.spawn_module("teleopctl.nodes", ["mujoco_sim", "mujoco_sim"])
    ros.spawn_module("teleopctl.nodes", ["camera", "camera", "--ros-args", "-p", "quality:=fast"])
    sim.wait_for_line("Simulation is running")

    def column() -> float:
        image = viewer.images[-1]
        red, green, blue = np.moveaxis(pixels(image).astype(int), -1, 0)
        return float(np.nonzero(red > np.maximum(green, blue) + 60)[1].mean())

    viewer.look()
    viewer.wait(lambda: bool(viewer.images))
    # Its front is 2.8 m away and half the picture, 80 pixels, is as wide as tan 0.6 of that.
    pixels_per_metre = 80 / (2.8 * np.tan(0.6))
    assert column() == pytest.approx(79.5 - 0.6 * pixels_per_metre, abs=3), "to the left"

    place = get_message("mujoco_ros2_control_msgs/msg/FreeJointState")(name="cube")
    place.pose.pose.position.x, place.pose.pose.position.y = 3.0, -0.6
    place.pose.pose.position.z = 0.2
    assert partner.call("SetFreeJointState", "set_free_joint_state", free_joints=[place]).success
    viewer.wait(lambda: abs(column() - (79.5 + 0.6 * pixels_per_metre)) < 3)
    partner.close()


EYES = """<robot name="scene"><link name="world"/><link name="eye"/>
<joint name="mount" type="fixed"><parent link="world"/><child link="eye"/>
  <origin xyz="0 0 0.5"/></joint>
<gazebo reference="eye"><sensor name="eye" type="rgbd_camera"><update_rate>10</update_rate>
  <camera name="eye"><horizontal_fov>1.2</horizontal_fov>
  <image><width>160</width><height>120</height></image></camera></sensor>
  <sensor name="names" type="segmentation_camera"><update_rate>10</update_rate>
  <camera name="names"><horizontal_fov>1.2</horizontal_fov>
  <image><width>160</width><height>120</height></image></camera></sensor></gazebo></robot>"""
PLATE = "things: {plate: {shape: box, size: [0.1, 0.4, 0.4], color: red}}"


@pytest.mark.nightly
def test_what_comes_later_is_drawn_where_the_pinhole_has_it_until_it_leaves(
    ros: RosGraph, viewer: Viewer
) -> None:
    partner = Partner(EYES)
    sim = ros.spawn_module("teleopctl.nodes", ["mujoco_sim", "mujoco_sim"])
    ros.spawn_module("teleopctl.nodes", ["camera", "camera", "--ros-args", "-p", "quality:=fast"])
    sim.wait_for_line("Simulation is running")
    clouds: list = []
    labels: list = []
    meanings: list = []
    viewer.collect("sensor_msgs/msg/Image", "/eye/image", viewer.images)
    viewer.collect("sensor_msgs/msg/PointCloud2", "/eye/points", clouds)
    viewer.collect("sensor_msgs/msg/Image", "/names/labels_map", labels)
    viewer.collect(
        "vision_msgs/msg/LabelInfo", "/names/labels_map/label_info", meanings, qos_profile_latched
    )

    def red() -> np.ndarray:
        """Rows and columns of what is red, (2, n)."""
        colours = pixels(viewer.images[-1]).astype(int)
        return np.array(np.nonzero(colours[..., 0] > colours[..., 1:].max(axis=-1) + 60))

    def names() -> set[str]:
        meaning = {each.class_id: each.class_name for each in meanings[-1].class_map}
        return {meaning.get(number, "") for number in np.unique(list(labels[-1].data))}

    viewer.wait(lambda: viewer.images and clouds and labels and meanings)
    assert not red().size and "plate" not in names()

    spawn = get_service("simulation_interfaces/srv/SpawnEntity")
    request = spawn.Request(resource_string=PLATE)
    # Its front is 3 m ahead, 0.5 m to the left and 0.2 m above the eye.
    place = request.initial_pose.pose.position
    place.x, place.y, place.z = 3.05, 0.5, 0.7
    partner.call_as(spawn, "/spawn_entity", request)
    focal = 80 / np.tan(0.6)
    column, row = 79.5 - focal * 0.5 / 3, 59.5 - focal * 0.2 / 3
    viewer.wait(lambda: red().size and "plate" in names())
    assert red().mean(axis=1) == pytest.approx([row, column], abs=1)
    viewer.wait(lambda: abs(depth(clouds[-1], row, column) - 3.0) < 1e-3)

    delete = get_service("simulation_interfaces/srv/DeleteEntity")
    partner.call_as(delete, "/delete_entity", delete.Request(entity="plate"))
    viewer.wait(lambda: not red().size and "plate" not in names())
    viewer.wait(lambda: not abs(depth(clouds[-1], row, column)) < 4.0)
    partner.close()


# Tells how many contexts of OpenGL there are at most at a time, and models that are built.
COUNTING = """
import sys
from teleopctl.sim import choose_backend
choose_backend()
import mujoco
import teleopctl.nodes.camera as camera
from teleopctl import mujoco_model
counts = {"alive": 0, "most": 0, "models": 0}
class Counted:
    def __init__(self, *size):
        self._gl = mujoco_context(*size)
        counts["alive"] += 1
        counts["most"] = max(counts["most"], counts["alive"])
    def make_current(self):
        self._gl.make_current()
    def free(self):
        counts["alive"] -= 1
        self._gl.free()
def building(*args, **kwargs):
    counts["models"] += 1
    return build(*args, **kwargs)
mujoco_context, build = mujoco.GLContext, mujoco_model.build_model
mujoco.GLContext, mujoco_model.build_model = Counted, building
camera.check_drawing = lambda: None
camera.main(sys.argv)
print(counts["most"], counts["alive"], counts["models"], flush=True)
"""


@pytest.mark.nightly
def test_all_cameras_are_drawn_from_one_model_with_one_context(
    ros: RosGraph, viewer: Viewer
) -> None:
    partner = Partner(EYES)
    sim = ros.spawn_module("teleopctl.nodes", ["mujoco_sim", "mujoco_sim"])
    words = ["-c", COUNTING, "--ros-args", "-p", "quality:=fast"]
    drawing = ros.spawn_command([sys.executable, *words])
    sim.wait_for_line("Simulation is running")
    labels: list = []
    viewer.collect("sensor_msgs/msg/Image", "/eye/image", viewer.images)
    viewer.wait(lambda: viewer.images)
    viewer.collect("sensor_msgs/msg/Image", "/names/labels_map", labels)
    viewer.wait(lambda: labels)
    viewer.images.clear()
    viewer.wait(lambda: viewer.images)

    drawing.interrupt()
    drawing.wait()
    assert drawing.stdout.split() == ["1", "0", "1"], drawing.stderr
    partner.close()


def depth(cloud: Any, row: float, column: float) -> float:
    """How far a point of a cloud of 160 by 120 is, along the optical axis."""
    points = np.frombuffer(cloud.data, np.float32).reshape(120, 160, 4)
    return float(points[round(row), round(column), 2])


def test_the_camera_info_has_the_intrinsics_of_the_sensor(camera: Process, viewer: Viewer) -> None:
    viewer.read_info()
    viewer.wait(lambda: len(viewer.infos) >= 3)

    info = viewer.infos[-1]
    assert (info.width, info.height, info.distortion_model) == (2304, 1296, "plumb_bob")
    assert list(info.d) == [0.0] * 5
    assert info.header.frame_id == "rgb_camera_optical"
    focal = 1152 / np.tan(0.575)
    assert list(info.k) == pytest.approx([focal, 0, 1151.5, 0, focal, 647.5, 0, 0, 1])
    # Its <hackBaseline>, in metres, as gazebo_ros_camera has it: minus the focal length times that.
    moved = -0.2 * focal
    assert list(info.p) == pytest.approx([focal, 0, 1151.5, moved, 0, focal, 647.5, 0, 0, 0, 1, 0])
    assert "drawing" not in camera.stderr, "nobody looked at an image"


def test_images_come_only_while_somebody_looks(
    camera: Process, partner: Partner, viewer: Viewer
) -> None:
    view = "/mujoco_sim/joint_states"
    assert partner.count_subscribers(view) == 0

    viewer.look()
    viewer.wait(lambda: len(viewer.images) >= 2)
    camera.wait_for_line("drawing at quality fast")
    assert partner.count_subscribers(view) == 1
    stamps = [stamp_ns(image) for image in viewer.images]
    assert all(later - earlier >= 30_000_000 for earlier, later in itertools.pairwise(stamps))

    gone = threading.Event()
    partner.add_graph_callback(lambda: gone.set() if partner.count_subscribers(view) == 0 else None)
    viewer.look_away()
    assert gone.wait(LONGEST_WAIT_S), "the camera no longer follows the state"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="EGL is Linux's")
def test_a_machine_that_cannot_draw_is_told_which_packages_to_install(
    ros: RosGraph,
) -> None:
    # EGL without a driver, which is what a machine without libgl1-mesa-dri has.
    ros.env |= {"MUJOCO_GL": "egl", "__EGL_VENDOR_LIBRARY_DIRS": os.devnull}
    camera = ros.spawn_module("teleopctl.nodes", ["camera", "camera"])

    assert camera.wait() == 1
    assert "a system library for drawing is missing" in camera.stderr
    assert "libegl1 libgl1-mesa-dri" in camera.stderr
    assert "libosmesa6" in camera.stderr
    assert "Traceback" not in camera.stderr


def test_for_a_robot_without_cameras_no_model_is_built(
    ros: RosGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("teleopctl.mujoco_model.build_model", None)
    bare = "robot_description:=<robot name='bare'><link name='base'/></robot>"
    with init(args=["--ros-args", "-p", bare]), CameraNode() as camera:
        assert camera.get_publishers_info_by_topic("/camera_info") == []


def test_the_model_is_built_once_the_simulator_publishes_states(
    ros: RosGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Enough(Exception):
        """The camera has begun to build its model."""

    steps: list[str] = []

    def wait(node: CameraNode, kind: object, topic: str, *_: object) -> bool:
        steps.append(f"wait for {topic}")
        return True

    def build(*_: object, **__: object) -> None:
        steps.append("build")
        raise Enough

    monkeypatch.setattr(CameraNode, "wait_for_match", wait)
    monkeypatch.setattr("teleopctl.mujoco_model.build_model", build)
    described = f"robot_description:={teleop_urdf()}"
    with init(args=["--ros-args", "-p", described]), pytest.raises(Enough):
        CameraNode()
    assert steps == ["wait for /mujoco_sim/joint_states", "build"]


def test_an_unknown_quality_is_refused(ros: RosGraph) -> None:
    camera = ros.spawn_module(
        "teleopctl.nodes", ["camera", "camera", "--ros-args", "-p", "quality:=best"]
    )

    assert camera.wait() == 1
    assert "auto, fast, full" in camera.stderr
    assert "Traceback" not in camera.stderr


@pytest.mark.nightly
def test_the_quality_can_be_changed_while_it_draws(
    ros: RosGraph, camera: Process, viewer: Viewer
) -> None:
    viewer.look()
    camera.wait_for_line("drawing at quality fast")

    assert ros.run("param set /camera quality full").stdout == "Set parameter successful\n"

    camera.wait_for_line("drawing at quality full")


@pytest.mark.nightly
def test_what_cannot_be_changed_is_refused(ros: RosGraph, camera: Process) -> None:
    wrong = ros.run("param set /camera quality best")
    assert (wrong.returncode, wrong.stdout) == (1, "")
    assert "quality is one of auto, fast, full" in wrong.stderr

    late = ros.run("param set /camera camera other")
    assert late.returncode == 1
    assert "read-only" in late.stderr
