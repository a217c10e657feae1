"""The world around the arm: a table, and a cube that is gripped and lifted."""

import json
import math
import threading
from typing import Any

import numpy as np
import pytest

from teleopctl.interfaces.store import get_message
from teleopctl.node import Context, Node, qos_profile_latched
from teleopctl.packages import package_share
from teleopctl.testing import LONGEST_WAIT_S, RosGraph
from tests.samples import sample
from tests.system.sim_partner import Partner, command, stamp_ns, teleop_urdf

TABLE = package_share("teleopctl") / "worlds" / "table.urdf"
BODIES = "/mujoco_sim/free_joint_states"
MARKERS = "/mujoco_sim/world_markers"
ON_TABLE_M, LIFTED_M = 0.17, 0.5

FreeJointStateArray = get_message("mujoco_ros2_control_msgs/msg/FreeJointStateArray")
JointState = get_message("sensor_msgs/msg/JointState")
MarkerArray = get_message("visualization_msgs/msg/MarkerArray")
TFMessage = get_message("tf2_msgs/msg/TFMessage")
Image = get_message("sensor_msgs/msg/Image")


class Watcher(Node):
    """Notes where the joints and the cube are."""

    def __init__(self) -> None:
        self._own = Context()
        self._own.init(args=[])
        super().__init__("watcher", context=self._own, start_parameter_services=False)
        self._changed = threading.Condition()
        self.received = 0
        self.joints: dict[str, float] = {}
        self.cube: tuple[float, float, float] | None = None
        self.create_subscription(JointState, "/joint_states", self._on_joints, 10, immediate=True)
        self.create_subscription(FreeJointStateArray, BODIES, self._on_bodies, 10, immediate=True)

    def _on_joints(self, message: Any) -> None:
        with self._changed:
            self.received += 1
            self.joints = dict(zip(message.name, message.position, strict=True))
            self._changed.notify_all()

    def _on_bodies(self, message: Any) -> None:
        place = message.free_joints[0].pose.pose.position
        with self._changed:
            self.cube = place.x, place.y, place.z
            self._changed.notify_all()

    def wait(self, what: Any) -> None:
        with self._changed:
            assert self._changed.wait_for(what, LONGEST_WAIT_S), f"{self.joints} {self.cube}"

    def wait_for_joint(self, name: str, position: float, within: float = 2e-3) -> None:
        self.wait(lambda: abs(self.joints.get(name, math.inf) - position) < within)

    def wait_for_ticks(self, count: int) -> None:
        last = self.received + count
        self.wait(lambda: self.received >= last)

    def close(self) -> None:
        self._own.try_shutdown()


@pytest.fixture
def watcher(ros: RosGraph):
    node = Watcher()
    yield node
    node.close()


def test_the_arm_of_sim_yaml_lifts_the_cube_and_a_reset_puts_it_back(
    ros: RosGraph, watcher: Watcher
) -> None:
    done = ros.run("launch sim.yaml camera:=false --detach", timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr

    def arm(joint_2: float) -> None:
        point = {"positions": [0.0, joint_2, 0.0], "time_from_start": {"sec": 1}}
        message = {"joint_names": ["joint_1", "joint_2", "joint_3"], "points": [point]}
        topic = "/arm_controller/joint_trajectory trajectory_msgs/msg/JointTrajectory"
        ros.run(["topic", "pub", "--once", *topic.split(), json.dumps(message)])
        watcher.wait_for_joint("joint_2", joint_2)

    def gripper(position: float) -> None:
        topic = "/gripper_controller/commands std_msgs/msg/Float64MultiArray"
        ros.run(["topic", "pub", "--once", *topic.split(), f"{{data: [{position}]}}"])

    gripper(-0.6)
    watcher.wait_for_joint("joint_4", -0.6)
    arm(-0.77)
    watcher.wait(lambda: watcher.cube is not None)
    assert watcher.cube == pytest.approx((-0.15, 1.5, ON_TABLE_M), abs=2e-3)
    gripper(0.0)
    # The cube is between the fingers: they do not close.
    watcher.wait_for_joint("joint_4", -0.106, within=0.005)
    arm(-0.4)
    watcher.wait(lambda: watcher.cube is not None and watcher.cube[2] > LIFTED_M)

    type_name = "mujoco_ros2_control_msgs/srv/ResetWorld"
    assert ros.run(["service", "call", "/mujoco_sim/reset_world", type_name, "{}"]).returncode == 0
    watcher.wait(lambda: watcher.cube == pytest.approx((-0.15, 1.5, ON_TABLE_M), abs=2e-3))
    watcher.wait_for_joint("joint_2", 0.0)
    watcher.wait_for_ticks(3)
    assert watcher.joints["joint_2"] == pytest.approx(0.0, abs=2e-3), "its controllers hold it"


# Seconds, and where joint_2 and joint_4 are to be then.
PLAN = ((0.0, 0.0, 0.0), (1.0, 0.0, -0.6), (3.0, -0.77, -0.6), (4.0, -0.77, 0.0), (6.0, -0.4, 0.0))


def follow(state: Any) -> Any:
    seconds, joint_2, joint_4 = zip(*PLAN, strict=True)
    now = stamp_ns(state) * 1e-9
    return command(
        state,
        joint_1=0.0,
        joint_2=float(np.interp(now, seconds, joint_2)),
        joint_3=0.0,
        joint_4=float(np.interp(now, seconds, joint_4)),
    )


def lift(ros: RosGraph) -> list[tuple[int, Any]]:
    """Where the cube is at each control tick that was seen, while the arm lifts it."""
    partner = Partner(teleop_urdf())
    flags = ["-p", f"world:={TABLE}", "-p", "paused:=true", "-p", "real_time_factor:=0"]
    sim = ros.spawn_module("teleopctl.nodes", ["mujoco_sim", "mujoco_sim", "--ros-args", *flags])
    sim.wait_for_line("Simulation is paused")
    assert "[WARN]" not in sim.stderr
    seen: list[tuple[int, Any]] = []
    partner.create_subscription(
        FreeJointStateArray,
        BODIES,
        lambda m: seen.append((stamp_ns(m), m.free_joints[0])),
        1000,
        immediate=True,
    )
    partner.connect(follow)
    while not seen:  # until the simulator has seen who listens
        assert partner.call("StepSimulation", "step_simulation", steps=100).success
    steps = 6500 - seen[-1][0] // 1_000_000
    assert partner.call("StepSimulation", "step_simulation", steps=steps).success
    partner.wait(lambda: bool(seen) and seen[-1][0] >= 6_480_000_000)
    partner.close()
    sim.interrupt()
    sim.wait()
    return seen


@pytest.mark.nightly
def test_the_cube_is_lifted_the_same_way_twice(ros: RosGraph) -> None:
    first, second = dict(lift(ros)), dict(lift(ros))

    assert first[max(first)].pose.pose.position.z > LIFTED_M
    common = set(first) & set(second)
    assert len(common) > 300
    assert all(first[time] == second[time] for time in common)


def test_the_world_is_on_the_topics_that_rviz_reads(ros: RosGraph) -> None:
    partner = Partner(teleop_urdf())
    kept: list[Any] = []
    plain: list[Any] = []
    frames: list[Any] = []
    partner.create_subscription(TFMessage, "/tf", frames.append, 10, immediate=True)
    partner.create_subscription(
        MarkerArray, MARKERS, kept.append, qos_profile_latched, immediate=True
    )
    sim = ros.spawn_module(
        "teleopctl.nodes", ["mujoco_sim", "mujoco_sim", "--ros-args", "-p", f"world:={TABLE}"]
    )
    sim.wait_for_line("Simulation is running")
    partner.wait(lambda: bool(kept) and bool(frames))
    assert {(marker.ns, marker.header.frame_id) for marker in kept[0].markers} == {
        ("table", "world"),
        ("cube", "cube"),
    }
    transform = frames[0].transforms[0]
    assert (transform.header.frame_id, transform.child_frame_id) == ("world", "cube")

    # RViz asks for no message that is kept, unless it is told to.
    partner.create_subscription(MarkerArray, MARKERS, plain.append, 10, immediate=True)
    partner.wait(lambda: bool(plain))
    partner.close()


@pytest.mark.nightly
def test_the_camera_looks_at_the_cube(ros: RosGraph) -> None:
    partner = Partner(teleop_urdf())
    flags = ["--ros-args", "-p", f"world:={TABLE}", "-p", "quality:=fast"]
    for program in ("mujoco_sim", "camera"):
        ros.spawn_module("teleopctl.nodes", [program, program, *flags])
    images: list[Any] = []
    partner.create_subscription(Image, "/image_raw", images.append, 1, immediate=True)
    partner.wait(lambda: bool(images))
    image = images[0]
    picture = np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, 3).astype(int)
    red = picture[:, :, 0] > picture[:, :, 1:].max(axis=2) + 60
    rows, columns = np.nonzero(red)
    # 10 cm at 1.05 m, by 1778 pixels of focal length; 15 cm to the left.
    assert np.ptp(columns) == pytest.approx(180, abs=20)
    assert columns.mean() == pytest.approx(1152 - 0.15 * 1778 / 1.05, abs=20)
    assert 300 < rows.mean() < 1000
    partner.close()


@pytest.mark.parametrize(
    ("content", "message"),
    sample(
        [
            (None, "Cannot read {file}: No such file or directory"),
            ("<robot>\n<link", "{file}:2: invalid XML: "),
            (
                "<robot name='w'>\n<link name='a'/><link name='b'/></robot>",
                "{file}: Two root links",
            ),
        ],
        3,
    ),
)
def test_a_world_with_a_mistake_is_told_once_and_nothing_is_started(
    ros: RosGraph, content: str | None, message: str
) -> None:
    file = ros.folder / "world.urdf"
    if content is not None:
        file.write_text(content)
    done = ros.run("launch sim.yaml world:=world.urdf --detach")
    assert done.returncode == 1
    assert done.stdout == ""
    # On a loaded machine a line about the progress stands before it.
    (line,) = [each for each in done.stderr.splitlines() if not each.startswith("Starting: ")]
    assert message.format(file=file) in line


@pytest.mark.nightly
def test_a_robot_of_ones_own_stands_in_an_empty_world_unless_it_is_given_one(
    ros: RosGraph,
) -> None:
    (ros.folder / "own.urdf").write_text(teleop_urdf(), encoding="utf-8")
    words = ["launch", "sim.yaml", "model:=own.urdf", "camera:=false", "--detach"]
    for world, shown in (((), False), ((f"world:={TABLE}",), True)):
        done = ros.run([*words, *world])
        assert done.returncode == 0, done.stderr
        assert "WARNING" not in done.stderr
        assert (MARKERS in ros.run("topic list").stdout.splitlines()) == shown
        assert ros.run("stop --all").returncode == 0


@pytest.mark.nightly
def test_a_free_robot_starts_where_it_is_asked_to(ros: RosGraph) -> None:
    crate = (
        '<robot name="crate"><link name="crate"><inertial><mass value="1"/><inertia ixx="0.1" '
        'iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry>'
        '<box size="0.2 0.2 0.2"/></geometry></collision></link></robot>'
    )
    (ros.folder / "crate.urdf").write_text(crate, encoding="utf-8")
    words = ["launch", "sim.yaml", "model:=crate.urdf", "spawn_pose:=[-2, 0.5, 0, 0, 0, 1.5708]"]
    assert ros.run([*words, "paused:=true", "--detach"]).returncode == 0
    request = "{entity: crate}"
    asked = ros.run(
        [
            "service",
            "call",
            "/get_entity_state",
            "simulation_interfaces/srv/GetEntityState",
            request,
        ]
    )
    assert "Point(x=-2.0, y=0.5, z=0." in asked.stdout
    assert "z=0.70710" in asked.stdout
