"""Cameras and sensors of MJCF files: judged by what MuJoCo itself makes of the same file."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from teleopctl.interfaces import get_message
from teleopctl.mujoco_model import CameraModel
from teleopctl.robot import Joints, RobotDescription, SegmentTree, read_model
from teleopctl.sim.building import SimulatedRobot, simulate
from teleopctl.sim.cameras.lens import camera_projection
from teleopctl.tf import Transform

PERIOD_NS = 10_000_000

ROBOT = """
<mujoco model="head">
  <option magnetic="1e-5 2e-5 -4e-5"/>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <camera name="room" pos="0 -2 1" xyaxes="1 0 0 0 0.4 1" fovy="60" resolution="320 200"/>
    <camera name="chase" mode="targetbody" target="neck" pos="1 1 1"/>
    <camera name="map" projection="orthographic" pos="0 0 3"/>
    <body name="stand" pos="1 0 0"><geom size="0.1"/><camera name="beside" euler="90 0 20"/></body>
    <site name="map_table" pos="0.5 0.4 0.3" euler="0 0 30"/>
    <body name="base" pos="0 0 0.5">
      <geom type="box" size="0.1 0.1 0.1"/>
      <body name="neck" pos="0 0 0.2">
        <joint name="yaw" axis="0 0 1" damping="1"/>
        <geom type="box" size="0.05 0.05 0.05" mass="2"/>
        <site name="chip" pos="0.1 0.02 0.03" euler="10 20 30"/>
        <site name="wrist" pos="0 0.1 0" euler="0 40 0"/>
        <site name="sole" pos="0 0 -0.05" size="0.2"/>
        <site name="down" pos="0.3 0 0" euler="180 0 0"/>
        <camera name="eye-1" pos="0.05 0 0" euler="90 -90 0" resolution="64 48"
          sensorsize="0.004 0.003" focal="0.005 0.006" principal="0.0004 0.0002"/>
      </body>
    </body>
    <body name="ball" pos="0.3 0 0.25"><freejoint/>
      <geom size="0.02"/><site name="loose"/></body>
  </worldbody>
  <sensor>
    <jointpos joint="yaw"/><actuatorfrc actuator="motor"/><clock name="clock"/>
    <gyro name="rate" site="chip" noise="0.01" interval="0.02"/>
    <accelerometer site="chip"/>
    <framequat objtype="site" objname="chip"/>
    <gyro name="lonely" site="wrist"/>
    <force site="wrist"/><torque site="wrist" cutoff="7"/>
    <touch name="grip" site="sole"/>
    <rangefinder name="altitude" site="down"/>
    <magnetometer site="chip"/>
    <velocimeter name="speed" site="chip"/>
    <touch name="rolling" site="loose"/>
    <framepos name="place" objtype="xbody" objname="neck"/>
    <framelinvel name="motion" objtype="xbody" objname="neck"/>
    <framepos name="relative" objtype="xbody" objname="neck" reftype="xbody" refname="ball"/>
    <subtreecom name="middle" body="base"/>
    <framelinacc name="pull" objtype="site" objname="chip"/>
    <framequat name="facing" objtype="xbody" objname="neck" reftype="site" refname="map_table"
      noise="0.1"/>
    <framexaxis name="ahead" objtype="site" objname="chip"/>
    <framezaxis name="heading" objtype="xbody" objname="ball" reftype="site" refname="chip"/>
    <distance name="gap" body1="neck" body2="ball" cutoff="10"/>
    <fromto name="between" body1="neck" body2="ball" cutoff="10"/>
    <insidesite name="inside" site="sole" objtype="xbody" objname="ball"/>
    <e_potential name="energy"/>
    <tendonpos name="stretch" tendon="rope"/>
    <actuatorpos name="winch" actuator="winch"/>
    <jointpos name="encoder" joint="yaw" noise="0.005"/>
    <camprojection name="pixel" camera="eye-1" site="loose"/>
    <contact name="feet" num="2" data="found force"/>
    <user name="own" dim="2"/>
  </sensor>
  <tendon><spatial name="rope"><site site="wrist"/><site site="loose"/></spatial></tendon>
  <actuator><motor name="motor" joint="yaw"/><motor name="winch" tendon="rope"/></actuator>
</mujoco>
"""


class Simulated:
    """The robot in simulation, half a second after its start."""

    def __init__(self, file: Path, **options: Any) -> None:
        self.said: list[str] = []
        self.robot: SimulatedRobot = simulate(
            read_model(file).text, control_period_ns=PERIOD_NS, warn=self.said.append, **options
        )
        self.robot.simulation.apply(["yaw"], [], [], [0.7])
        self.robot.simulation.step_to(500_000_000)
        self.model, self.data = self.robot.simulation.observe()
        self.sensors = {sensor.topic: sensor for sensor in self.robot.sensors}
        self.description = self.robot.description

    @classmethod
    def of_text(cls, file: Path, text: str) -> "Simulated":
        """A robot of its own, in this file."""
        file.write_text(text)
        return cls(file)

    def read(self, topic: str) -> Any:
        sensor = self.sensors[topic]
        message = get_message(sensor.message_type)()
        sensor.read(self.model, self.data, message)
        return message

    def of_file(self, name: str) -> list[float]:
        """What MuJoCo's sensor of a name has."""
        return list(self.data.sensor(name).data)

    def frames(self) -> dict[str, Transform]:
        """Where each link is in the world."""
        simulation = self.robot.simulation
        simulation.read()
        tree = SegmentTree(self.description, Joints.of(self.description))
        positions = dict(zip(simulation.joint_names, simulation.positions, strict=True))
        moved = {joint.child: place for joint, place in tree.transforms(positions)}
        moved |= {segment.joint.child: segment.origin for segment in tree.fixed}
        found = {self.description.root: Transform()}
        for joint in self.description.tree:
            found[joint.child] = found[joint.parent] @ moved[joint.child]
        return found


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("head") / "robot.xml"
    file.write_text(ROBOT)
    return file


@pytest.fixture(scope="module")
def head(file: Path) -> Simulated:
    return Simulated(file)


def xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def turn(rotation: tuple[float, ...]) -> np.ndarray:
    """The matrix of a rotation x y z w."""
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, np.array([rotation[3], *rotation[:3]]))
    return matrix.reshape(3, 3)


def test_a_camera_sees_what_mujocos_own_sees(head: Simulated) -> None:
    cameras = {camera.name: camera for camera in head.robot.model.cameras}
    scene, look = mujoco.MjvScene(head.model, 100), mujoco.MjvCamera()
    look.type = mujoco.mjtCamera.mjCAMERA_FIXED
    for name, camera in cameras.items():
        look.fixedcamid = head.model.camera(name).id
        mujoco.mjv_updateScene(
            head.model, head.data, mujoco.MjvOption(), mujoco.MjvPerturb(), look,
            mujoco.mjtCatBit.mjCAT_ALL, scene,
        )  # fmt: skip
        eye, view = scene.camera[0], camera_projection(camera)
        near = float(eye.frustum_near)
        half = eye.frustum_width or eye.frustum_top * camera.width / camera.height
        edges = [eye.frustum_bottom, eye.frustum_top]
        edges += [eye.frustum_center - half, eye.frustum_center + half]
        assert camera.near == pytest.approx(near)
        assert [view.bottom, view.top, view.left, view.right] == pytest.approx(
            [edge / near for edge in edges], rel=1e-5
        )
    sizes = {name: (camera.width, camera.height) for name, camera in cameras.items()}
    assert sizes == {"room": (320, 200), "beside": (640, 480), "eye-1": (64, 48)}


def test_images_are_in_optical_frames_where_the_cameras_look(head: Simulated) -> None:
    frames = head.frames()
    topics = {}
    for camera in head.robot.model.cameras:
        topics[camera.frame_id] = (camera.topics["image"], camera.topics["info"])
        own = frames[camera.link] @ Transform(camera.pose.xyz, camera.optical_rotation)
        state = head.data.camera(camera.name)
        assert own.translation == pytest.approx(state.xpos, abs=1e-6)
        # MuJoCo's y is up and it looks along -z; in an optical frame y is down and z forward.
        assert turn(own.rotation) == pytest.approx(
            state.xmat.reshape(3, 3) @ np.diag([1, -1, -1]), abs=1e-6
        )
    assert topics == {
        f"{name}_optical": (f"{name}/image_raw", f"{name}/camera_info")
        for name in ("room", "beside", "eye_1")
    }


def test_what_mujoco_measures_on_a_site_is_one_message_in_its_frame(head: Simulated) -> None:
    imu, wrench = head.read("chip"), head.read("wrist")
    q = imu.orientation

    assert xyz(imu.linear_acceleration) == pytest.approx(head.of_file("chip_accelerometer"))
    assert [q.w, q.x, q.y, q.z] == pytest.approx(head.of_file("chip_framequat"))
    assert xyz(wrench.wrench.force) == pytest.approx(head.of_file("wrist_force"))
    assert np.linalg.norm(xyz(wrench.wrench.torque)) > 1.0
    assert xyz(wrench.wrench.torque) == pytest.approx(head.of_file("wrist_torque"))
    frames = head.frames()
    for site in ("chip", "wrist"):
        state = head.data.site(site)
        assert head.sensors[site].frame_id == site
        assert frames[site].translation == pytest.approx(state.xpos, abs=1e-6)
        assert turn(frames[site].rotation) == pytest.approx(state.xmat.reshape(3, 3), abs=1e-6)


def test_noise_and_interval_are_those_of_the_file(head: Simulated, file: Path) -> None:
    imu, rate = head.read("chip"), head.of_file("rate")
    error = np.subtract(xyz(imu.angular_velocity), rate)

    assert np.abs(error).max() < 0.05
    assert np.abs(error).min() > 0.0
    assert list(imu.angular_velocity_covariance)[::4] == pytest.approx([1e-4] * 3)
    assert head.sensors["chip"].description.update_rate == 50
    again, other = Simulated(file).read("chip"), Simulated(file, seed=1).read("chip")
    assert xyz(again.angular_velocity) == xyz(imu.angular_velocity)
    assert xyz(other.angular_velocity) != xyz(imu.angular_velocity)


def test_ranges_forces_of_touch_and_fields_are_those_of_the_file(head: Simulated) -> None:
    reach = head.read("altitude")
    frame = head.frames()[head.sensors["altitude"].frame_id]

    assert reach.range == pytest.approx(head.of_file("altitude")[0])
    # A Range looks along the x axis of its frame; this one at the floor, 0.7 m below.
    assert turn(frame.rotation)[:, 0] == pytest.approx([0, 0, -1], abs=1e-6)
    assert (reach.max_range, 0.1 < reach.range < 0.71) == (float("inf"), True)
    assert head.read("grip").data == head.of_file("grip")[0]
    field = head.read("chip_magnetometer").magnetic_field
    assert xyz(field) == pytest.approx(head.of_file("chip_magnetometer"))


def test_where_a_body_is_comes_as_odometry(head: Simulated) -> None:
    truth = head.read("/neck/odom")

    assert xyz(truth.pose.pose.position) == pytest.approx(head.of_file("place"))
    assert xyz(truth.twist.twist.linear) == pytest.approx(head.of_file("motion"))
    assert truth.child_frame_id == "neck"


def test_what_becomes_no_topic_is_named(head: Simulated) -> None:
    cameras = [line for line in head.said if line.startswith("Camera")]
    sensors = [line for line in head.said if "ensor" in line or "topic" in line]

    assert [line.partition(":")[0] for line in cameras] == [
        "Camera 'chase' is left out",
        "Camera 'map' is left out",
    ]
    assert sensors == [
        "Sensors of the file without a topic: 'own' (user)",
        "Without effect on topics: cutoff of 'wrist_torque', noise of 'facing'",
    ]


# Of each: the topic, its frame, and how its numbers are read.
TOLD_AS_THEY_ARE = {
    "lonely": ("wrist", "vector"),
    "speed": ("chip", "vector"),
    "relative": ("ball", "point"),
    "middle": ("world", "point"),
    "pull": ("world", "vector"),
    "facing": ("map_table", "quaternion"),
    "ahead": ("world", "vector"),
    "heading": ("chip", "vector"),
    "rolling": ("", "data"),
    "gap": ("", "data"),
    "inside": ("", "data"),
    "energy": ("", "data"),
    "stretch": ("", "data"),
    "winch": ("", "data"),
    "encoder": ("", "data"),
    "between": ("", "numbers"),
    "pixel": ("", "numbers"),
    "feet": ("", "numbers"),
}


@pytest.mark.parametrize("name", TOLD_AS_THEY_ARE)
def test_other_sensors_are_told_as_mujoco_reads_them(head: Simulated, name: str) -> None:
    frame, part = TOLD_AS_THEY_ARE[name]
    message = head.read(name)
    values = {
        "vector": lambda: xyz(message.vector),
        "point": lambda: xyz(message.point),
        "quaternion": lambda: [getattr(message.quaternion, part) for part in "wxyz"],
        "data": lambda: [message.data],
        "numbers": lambda: list(message.data),
    }[part]()

    assert values == pytest.approx(head.of_file(name), abs=0.02 if name == "encoder" else 1e-12)
    if frame:
        assert head.sensors[name].frame_id == frame
    if part == "numbers":
        assert [(d.label, d.size) for d in message.layout.dim] == [(name, len(values))]


def test_a_joints_sensor_is_a_topic_where_it_differs_from_the_joint(head: Simulated) -> None:
    assert head.read("encoder").data != head.of_file("encoder")[0]
    assert {"yaw_jointpos", "motor_actuatorfrc", "clock"}.isdisjoint(head.sensors)


def test_a_vector_is_in_a_frame_with_its_axes(head: Simulated) -> None:
    table, own = head.frames()["map_table"], head.data.site("map_table")

    assert table.translation == pytest.approx(own.xpos, abs=1e-6)
    assert turn(table.rotation) == pytest.approx(own.xmat.reshape(3, 3), abs=1e-6)


def test_what_mujoco_would_delay_is_measured_now(tmp_path: Path) -> None:
    file = tmp_path / "robot.xml"
    late = 'delay="0.1" interval="0.3" nsample="60"'
    file.write_text(
        ROBOT.replace('name="altitude"', f'name="altitude" {late}').replace(
            'name="speed"', f'name="speed" {late}'
        )
    )
    late_robot, robot = Simulated(file), Simulated.of_text(tmp_path / "exact.xml", ROBOT)

    assert late_robot.read("altitude").range == robot.read("altitude").range
    assert xyz(late_robot.read("speed").vector) == xyz(robot.read("speed").vector)
    assert late_robot.sensors["speed"].description.update_rate == pytest.approx(1 / 0.3)
    assert "Without effect on topics: cutoff of 'wrist_torque', delay of 'altitude', " in "".join(
        late_robot.said
    )


def test_a_camera_beside_a_free_robot_is_in_the_world(tmp_path: Path) -> None:
    file = tmp_path / "dog.xml"
    file.write_text(
        '<mujoco><worldbody><camera name="side" pos="0 -3 1" euler="90 0 0"/>'
        '<body name="dog" pos="0 0 1"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'
    )

    def camera(**options: Any) -> CameraModel:
        robot = simulate(read_model(file).text, control_period_ns=PERIOD_NS, **options)
        return robot.model.camera("side")

    assert "world" not in RobotDescription.from_urdf(read_model(file).text).links
    assert camera().link == "world"
    assert camera(fixed_base=True).link == "dog"
