"""The simulator as a process, in lockstep with a controller written here."""

import json
import math
import queue
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest

from teleopctl.interfaces.store import get_message, get_service
from teleopctl.node import Parameter
from teleopctl.testing import LONGEST_WAIT_S, Process, RosGraph, eventually
from tests.samples import sample
from tests.system.sim_partner import Partner, command, stamp_ns, teleop_urdf

PERIOD_NS = 100_000_000
FREE_BALL = """<robot name="ball"><link name="world"/><link name="ball"><inertial><mass value="1"/>
  <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="free" type="floating"><parent link="world"/><child link="ball"/>
  <origin xyz="2 0 0.1"/></joint></robot>"""
REST = {"joint_1": 0.0, "joint_2": 0.0, "joint_3": 0.0, "joint_4": 0.0}
TARGET = {"joint_1": 0.5, "joint_2": -0.3, "joint_3": 0.4, "joint_4": -1.0}


@pytest.fixture(scope="module")
def urdf() -> str:
    return teleop_urdf()


@pytest.fixture
def partner(ros: RosGraph, urdf: str) -> Iterator[Partner]:
    node = Partner(urdf)
    yield node
    node.close()


def start(ros: RosGraph, *parameters: str) -> Process:
    flags = [word for parameter in parameters for word in ("-p", parameter)]
    return ros.spawn_module("teleopctl.nodes", ["mujoco_sim", "mujoco_sim", "--ros-args", *flags])


def run_lockstep(ros: RosGraph, partner: Partner, count: int) -> list[tuple[int, bytes]]:
    """From a standstill to the target: stamp and raw state of each tick."""
    sim = start(ros, "paused:=true", "real_time_factor:=0")
    sim.wait_for_line("Simulation is paused")
    partner.connect(lambda state: command(state, **TARGET))
    assert partner.call("SetPause", "set_pause", paused=False).success
    states = partner.wait_for_states(count)
    sim.interrupt()
    sim.wait()
    return [
        (stamp_ns(s), s.position.tobytes() + s.velocity.tobytes() + s.effort.tobytes())
        for s in states
    ]


def test_states_carry_exact_stamps_and_follow_the_commands(ros: RosGraph, partner: Partner) -> None:
    sim = start(ros, "paused:=true", "real_time_factor:=0")
    sim.wait_for_line("Simulation is paused")
    partner.connect(lambda state: command(state, **TARGET))
    partner.call("SetPause", "set_pause", paused=False)

    states = partner.wait_for_states(40)

    assert [stamp_ns(state) for state in states] == [k * PERIOD_NS for k in range(40)]
    assert states[0].name == ["joint_1", "joint_2", "joint_3", "joint_4", "joint_5"]
    assert list(states[0].position) == pytest.approx([0.0] * 5, abs=1e-9)
    final = dict(zip(states[-1].name, states[-1].position, strict=True))
    assert final == pytest.approx(TARGET | {"joint_5": 1.0}, abs=1e-6)
    assert list(states[-1].velocity) == pytest.approx([0.0] * 5, abs=1e-6)


@pytest.mark.nightly
def test_two_runs_with_the_same_commands_are_identical(ros: RosGraph, urdf: str) -> None:
    runs = []
    for _ in range(2):
        partner = Partner(urdf)
        runs.append(run_lockstep(ros, partner, 30))
        partner.close()

    assert runs[0] == runs[1]


@pytest.mark.nightly
def test_a_controller_that_stops_answering_is_reported_once_and_taken_back(
    ros: RosGraph, partner: Partner
) -> None:
    sim = start(ros, "lockstep_timeout:=0.2", "real_time_factor:=5")
    sim.wait_for_line("Simulation is running")
    partner.connect(lambda state: command(state, **TARGET))
    partner.wait_for_states(20)
    # On a busy machine the partner is connected later than that after the start.
    late = sim.stderr.count("No command for the state")

    partner.answer = lambda state: None
    sim.wait_for_line(r"No command for the state of .* came within 0.2 s")
    partner.wait_for_states(len(partner.states) + 10)
    assert partner.states[-1].position[0] == pytest.approx(0.5, abs=1e-6)

    partner.answer = lambda state: command(state, **REST)
    sim.wait_for_line("The controller answers again")
    partner.wait(lambda: abs(partner.states[-1].position[0]) < 1e-6)
    assert sim.stderr.count("No command for the state") == late + 1


@pytest.mark.nightly
def test_a_controller_that_dies_leaves_the_joints_where_they_were_sent(
    ros: RosGraph, partner: Partner
) -> None:
    sim = start(ros, "real_time_factor:=5")
    sim.wait_for_line("Simulation is running")
    partner.connect(lambda state: command(state, **TARGET))
    partner.wait_for_states(15)

    partner.disconnect()

    sim.wait_for_line("The controller disappeared")
    partner.wait_for_states(len(partner.states) + 20)
    assert partner.states[-1].position[1] == pytest.approx(-0.3, abs=1e-6)


@pytest.mark.nightly
def test_two_controllers_at_once_are_told(ros: RosGraph, partner: Partner) -> None:
    sim = start(ros)
    sim.wait_for_line("Simulation is running")
    partner.connect(lambda state: command(state, **TARGET))
    partner.wait_for_states(1)

    partner.create_publisher(type(partner.states[0]), "/robot_joint_commands", 10)

    sim.wait_for_line(r"2 publishers on /robot_joint_commands \(partner, partner\)")


@pytest.mark.nightly
def test_the_same_description_again_is_no_news(ros: RosGraph, partner: Partner) -> None:
    sim = start(ros)
    sim.wait_for_line("Simulation is running")

    partner.describe(teleop_urdf())
    partner.describe(teleop_urdf(hardware="mock"))

    sim.wait_for_line("Another robot description was published; this simulator keeps the first")
    assert sim.stderr.count("Another robot description") == 1


def test_without_a_controller_the_arm_holds_its_initial_pose(
    ros: RosGraph, partner: Partner
) -> None:
    sim = start(ros, "real_time_factor:=0")
    sim.wait_for_line("Simulation is running")
    partner.wait(lambda: bool(partner.clocks) and partner.clocks[-1] > 5 * 1_000_000_000)

    partner.connect(lambda state: None)

    states = partner.wait_for_states(1)
    assert list(states[0].position) == pytest.approx([0.0] * 5, abs=1e-9)
    assert "No command" not in sim.stderr.split("Simulation is running")[0]


def test_paused_time_stands_still_and_can_be_stepped(ros: RosGraph, partner: Partner) -> None:
    sim = start(ros, "paused:=true")
    sim.wait_for_line("Simulation is paused")
    partner.connect(lambda state: command(state, **TARGET))
    assert partner.states == [] and {*partner.clocks} <= {0}

    assert partner.call("StepSimulation", "step_simulation", steps=150).success
    partner.wait(lambda: bool(partner.clocks) and partner.clocks[-1] == 150_000_000)
    assert [stamp_ns(state) for state in partner.states] == [0, PERIOD_NS]

    assert partner.call("SetPause", "set_pause", paused=False).success
    refused = partner.call("StepSimulation", "step_simulation", steps=1)
    assert not refused.success and "only while paused" in refused.message
    partner.wait_for_states(4)
    assert partner.call("SetPause", "set_pause", paused=True).success
    seen = len(partner.states)
    assert partner.call("StepSimulation", "step_simulation", steps=100).success
    partner.wait_for_states(seen + 1)
    stamps = [stamp_ns(state) for state in partner.states]
    assert stamps == [k * PERIOD_NS for k in range(seen + 1)]


def test_reset_world_puts_the_arm_back_while_time_goes_on(ros: RosGraph, partner: Partner) -> None:
    sim = start(ros, "paused:=true", "real_time_factor:=0")
    sim.wait_for_line("Simulation is paused")
    partner.connect(lambda state: command(state, **TARGET))
    partner.call("StepSimulation", "step_simulation", steps=2000)
    partner.answer = lambda state: command(state, joint_1=math.nan)

    assert partner.call("ResetWorld", "reset_world", keyframe="").success
    refused = partner.call("ResetWorld", "reset_world", keyframe="elsewhere")
    assert not refused.success and "elsewhere" in refused.message

    partner.call("StepSimulation", "step_simulation", steps=200)
    states = partner.wait_for_states(22)
    assert stamp_ns(states[-1]) == 21 * PERIOD_NS
    assert list(states[19].position)[:4] == pytest.approx(list(TARGET.values()), abs=1e-5)
    assert list(states[-1].position) == pytest.approx([0.0] * 5, abs=1e-9)


def test_the_start_is_told_as_in_ros_2(ros: RosGraph, partner: Partner) -> None:
    sim = start(ros, "paused:=true")
    sim.wait_for_line("Simulation is paused")

    text = sim.stderr
    expected = [
        "Connected to partner",
        "Received the robot description, parsing...",
        *(f"Loading joint: joint_{number}" for number in range(1, 6)),
        "Joint 'joint_5' is mimicking joint 'joint_4' with multiplier: -1",
        "Successful initialization of hardware 'RobotSystem'",
        "Successful 'configure' of hardware 'RobotSystem'",
        "Successful 'activate' of hardware 'RobotSystem'",
        "Desired controller update period (0.1 s) is slower than the simulation period (0.001 s).",
    ]
    places = [text.find(line) for line in expected]
    assert -1 not in places and places == sorted(places)


def test_the_pace_follows_the_parameter(ros: RosGraph, partner: Partner) -> None:
    sim = start(ros, "real_time_factor:=0.01")
    sim.wait_for_line("Simulation is running")
    result = ros.run("param set /mujoco_sim real_time_factor 0")
    assert result.returncode == 0, result.stderr

    partner.wait(lambda: bool(partner.clocks) and partner.clocks[-1] > 10 * 1_000_000_000)


@pytest.mark.nightly
def test_a_pace_that_is_none_is_refused_while_running(ros: RosGraph, partner: Partner) -> None:
    """Nor is one that is set together with what cannot be set."""
    sim = start(ros, "real_time_factor:=0.01")
    sim.wait_for_line("Simulation is running")
    for wrong in ("inf", "nan", "-1.0"):
        result = ros.run(f"param set /mujoco_sim real_time_factor {wrong}")
        assert (result.returncode, "expected a number" in result.stderr) == (1, True)
    set_ = get_service("rcl_interfaces/srv/SetParametersAtomically")
    client = partner.create_client(set_, "/mujoco_sim/set_parameters_atomically")
    assert client.wait_for_service(LONGEST_WAIT_S)
    both = [Parameter("real_time_factor", value=0.0), Parameter("state_rate", value=5)]
    request = set_.Request(parameters=[parameter.to_parameter_msg() for parameter in both])
    response: Any = client.call(request, timeout_sec=LONGEST_WAIT_S)
    assert not response.result.successful

    # Ten simulated seconds would take a thousand; at full speed, less than this command.
    assert "0.01" in ros.run("param get /mujoco_sim real_time_factor").stdout
    assert partner.clocks[-1] < 10 * 1_000_000_000
    # The smallest is one: time all but stands still, and the simulator answers.
    assert ros.run("param set /mujoco_sim real_time_factor 1e-300").returncode == 0
    assert ros.run("param get /mujoco_sim real_time_factor").returncode == 0
    assert sim.returncode is None


@pytest.mark.parametrize(
    ("parameter", "expected"),
    sample(
        [
            ("real_time_factor:=-1", "'real_time_factor' is -1, expected a number of at least 0"),
            (
                "real_time_factor:=.inf",
                "'real_time_factor' is inf, expected a number of at least 0",
            ),
            (
                "real_time_factor:=.nan",
                "'real_time_factor' is nan, expected a number of at least 0",
            ),
            (
                "lockstep_timeout:=.inf",
                "'lockstep_timeout' is inf, expected a number of at least 0",
            ),
            ("end_time:=1e300", "'end_time' is 1e+300, expected a number of at least 0"),
            (
                "update_rate:=3000000000",
                "'update_rate' is 3000000000, expected a number of at least 1",
            ),
            ("timestep:=fast", "'timestep' is 'fast', expected a number"),
        ],
        3,
    ),
)
def test_a_parameter_that_makes_no_sense_ends_with_one_sentence(
    ros: RosGraph, parameter: str, expected: str
) -> None:
    sim = start(ros, parameter)

    assert sim.wait() == 1
    assert expected in sim.stderr
    assert "Traceback" not in sim.stderr


@pytest.mark.nightly
def test_a_second_simulator_is_refused(ros: RosGraph, partner: Partner) -> None:
    first = ros.spawn_module("teleopctl.nodes", ["mujoco_sim", "mujoco_sim"])
    first.wait_for_line("Simulation is running")
    second = ros.run_module("teleopctl.nodes", ["mujoco_sim", "mujoco_sim"])
    assert second.returncode == 1
    assert "A node named /mujoco_sim is already running" in second.stderr
    assert first.returncode is None


def test_what_drawing_lacks_does_not_keep_physics_from_running(
    ros: RosGraph, partner: Partner
) -> None:
    ros.env["MUJOCO_GL"] = "bogus"
    sim = ros.spawn_module("teleopctl.nodes", ["mujoco_sim", "mujoco_sim"])
    sim.wait_for_line("Simulation is running")


IMU = (
    '<gazebo reference="horizontal_arm"><sensor name="imu" type="imu"><update_rate>30</update_rate>'
    "</sensor><sensor name='ear' type='microphone'/></gazebo></robot>"
)


@pytest.mark.nightly
def test_an_imu_is_published_on_its_own_beat_and_changes_nothing_of_the_run(
    ros: RosGraph, urdf: str
) -> None:
    runs = []
    received: list[tuple[int, str, float]] = []
    for text in (urdf, urdf.replace("</robot>", IMU)):
        partner = Partner(text)
        if text is not urdf:
            imu = get_message("sensor_msgs/msg/Imu")
            partner.create_subscription(
                imu,
                "/imu",
                lambda m: received.append(
                    (stamp_ns(m), m.header.frame_id, math.dist((0, 0, 0), xyz(m)))
                ),
                100,
                immediate=True,
            )
        runs.append(run_lockstep(ros, partner, 30))
        partner.close()

    assert runs[0] == runs[1]
    period_ns = round(1e9 / 30)
    # A millisecond is the physics step: the first one at or after each beat.
    assert len(received) > 80
    assert all(stamp % period_ns < 1_000_000 for stamp, _, _ in received)
    assert {frame for _, frame, _ in received} == {"horizontal_arm"}
    assert received[-1][2] == pytest.approx(9.81, abs=0.05), "the arm has come to rest"


def test_a_sensor_that_nothing_simulates_is_told_at_the_start(ros: RosGraph, urdf: str) -> None:
    partner = Partner(urdf.replace("</robot>", IMU))
    sim = start(ros)
    sim.wait_for_line(
        r"Sensor 'ear' on link 'horizontal_arm' \(line \d+\) is left out: nothing simulates"
    )
    partner.close()


FREE_BODIES = "/mujoco_sim/free_joint_states"

BALL = """<link name="ball"><inertial><mass value="1"/>
  <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="ball_joint" type="floating"><parent link="world"/><child link="ball"/>
  <origin xyz="3 0 20"/></joint></robot>"""


def test_a_free_body_is_published_and_can_be_put_elsewhere(ros: RosGraph, urdf: str) -> None:
    partner = Partner(urdf.replace("</robot>", BALL))
    sim = start(ros, "paused:=true")
    sim.wait_for_line("Simulation is paused")
    bodies: queue.Queue[Any] = queue.Queue()
    frames: queue.Queue[Any] = queue.Queue()
    array = get_message("mujoco_ros2_control_msgs/msg/FreeJointStateArray")
    partner.create_subscription(array, FREE_BODIES, bodies.put, 10, immediate=True)
    tf = get_message("tf2_msgs/msg/TFMessage")
    partner.create_subscription(tf, "/tf", frames.put, 10, immediate=True)

    def step(count: int) -> None:
        assert partner.call("StepSimulation", "step_simulation", steps=count).success

    def latest(time_ns: int) -> Any:
        while True:
            message = bodies.get(timeout=LONGEST_WAIT_S)
            if stamp_ns(message) == time_ns:
                return message.free_joints[0]

    while bodies.empty() or frames.empty():  # until the simulator has seen who listens
        step(1)
    begin_ns = partner.clocks[-1]
    step(100)
    t = begin_ns * 1e-9 + 0.1
    state = latest(begin_ns + 100_000_000)
    # In steps of 1 ms, semi-implicit Euler falls by g t (t + dt) / 2.
    assert state.name == "ball"
    assert state.pose.pose.position.z == pytest.approx(20.0 - 9.81 * t * (t + 1e-3) / 2.0)
    assert state.twist.twist.linear.z == pytest.approx(-9.81 * t)
    assert state.pose.header.frame_id == state.twist.header.frame_id == "world"
    assert stamp_ns(state.pose) == stamp_ns(state.twist) == begin_ns + 100_000_000
    transform = frames.get(timeout=LONGEST_WAIT_S).transforms[0]
    assert (transform.header.frame_id, transform.child_frame_id) == ("world", "ball")
    assert transform.transform.translation.x == 3.0

    # What is published can be put back as it is.
    assert partner.call("SetFreeJointState", "set_free_joint_state", free_joints=[state]).success
    place = get_message("mujoco_ros2_control_msgs/msg/FreeJointState")(name="ball")
    place.pose.header.frame_id = "claw_support"
    place.pose.pose.position.z = 5.0
    assert partner.call("SetFreeJointState", "set_free_joint_state", free_joints=[place]).success
    step(100)
    height = 1.457 + 5.0 - 9.81 * 0.1 * 0.101 / 2.0
    fallen = latest(begin_ns + 200_000_000).pose.pose.position.z
    assert fallen == pytest.approx(height, abs=1e-3)

    place.name = "stone"
    refused = partner.call("SetFreeJointState", "set_free_joint_state", free_joints=[place])
    assert not refused.success and "'stone' does not move freely; ball does" in refused.message
    overrides = get_message("mujoco_ros2_control_msgs/msg/SimulationState")()
    overrides.joint_states.name, overrides.joint_states.position = ["joint_1"], [0.7]
    assert partner.call("ResetWorld", "reset_world", state_overrides=overrides).success
    partner.connect(lambda state: None)
    step(100)
    assert partner.wait_for_states(1)[0].position[0] == pytest.approx(0.7, abs=1e-6)
    partner.close()


STATE_TOPICS = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/mujoco_sim/joint_states": "sensor_msgs/msg/JointState",
    "/mujoco_sim/free_joint_states": "mujoco_ros2_control_msgs/msg/FreeJointStateArray",
    "/mujoco_sim/contacts": "ros_gz_interfaces/msg/Contacts",
    "/tf": "tf2_msgs/msg/TFMessage",
}


@pytest.mark.nightly
def test_who_subscribes_while_time_stands_still_gets_the_state(
    ros: RosGraph, partner: Partner, tmp_path: Path
) -> None:
    file = tmp_path / "ball.urdf"
    file.write_text(FREE_BALL)
    sim = start(ros, "paused:=true", f"world:={file}")
    sim.wait_for_line("Simulation is paused")
    for _ in range(2):  # and once more, when others have subscribed before
        for topic, kind in STATE_TOPICS.items():
            seen: queue.Queue[Any] = queue.Queue()
            partner.create_subscription(get_message(kind), topic, seen.put, 10, immediate=True)
            seen.get(timeout=LONGEST_WAIT_S)


CRATE = """<robot name="crate"><link name="base_link"><inertial><mass value="1"/>
  <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="1 1 1"/></geometry></collision></link></robot>"""


@pytest.mark.nightly
def test_a_root_link_is_free_and_on_tf_only_when_that_is_asked_for(ros: RosGraph) -> None:
    partner = Partner(CRATE)
    sim = start(ros)
    sim.wait_for_line(
        "The root link 'base_link' is free, as in Gazebo, and starts resting on the ground; "
        "fixed_base:=true fixes it to the world"
    )
    bodies: queue.Queue[Any] = queue.Queue()
    frames: queue.Queue[Any] = queue.Queue()
    array = get_message("mujoco_ros2_control_msgs/msg/FreeJointStateArray")
    partner.create_subscription(array, FREE_BODIES, bodies.put, 10, immediate=True)
    tf = get_message("tf2_msgs/msg/TFMessage")
    partner.create_subscription(tf, "/tf", frames.put, 10, immediate=True)
    (body,) = bodies.get(timeout=LONGEST_WAIT_S).free_joints
    assert body.name == "base_link"
    assert body.pose.pose.position.z == pytest.approx(0.5, abs=1e-3)
    assert frames.empty()
    shown = ros.run("param set /mujoco_sim publish_base_tf true")
    assert shown.stdout == "Set parameter successful\n"
    (transform,) = frames.get(timeout=LONGEST_WAIT_S).transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("world", "base_link")
    partner.close()


WEIGHED = {
    "navsat": "<topic>/fix</topic>",
    "altimeter": "<topic>/height</topic>",
    "air_pressure": "<topic>/pressure</topic>",
    "magnetometer": "<topic>/field</topic>",
    "contact": "<topic>/touch</topic><contact><collision>base_link_collision</collision></contact>",
    "gpu_lidar": f"""<topic>/scan</topic><pose>0 0 0 0 {math.pi / 2} 0</pose><lidar>
      <scan><horizontal><samples>3</samples><min_angle>-0.5</min_angle><max_angle>0.5</max_angle>
      </horizontal></scan><range><min>0.1</min><max>9</max></range></lidar>""",
}


def test_what_sensors_measure_of_a_crate_at_rest_is_told_by_commands(ros: RosGraph) -> None:
    tags = "".join(
        f'<gazebo reference="base_link"><sensor name="{kind}" type="{kind}">'
        f"<update_rate>50</update_rate>{content}</sensor></gazebo>"
        for kind, content in WEIGHED.items()
    )
    partner = Partner(CRATE.replace("</robot>", f"{tags}</robot>"))
    sim = start(ros, "gps_origin:=[47.0, 8.0, 400.0]", "real_time_factor:=3.0")
    sim.wait_for_line("The root link 'base_link' is free")
    partner.wait(lambda: partner.clocks and partner.clocks[-1] > 2_000_000_000)
    topics = ("/fix", "/height", "/pressure", "/field", "/touch", "/scan")
    echoes = [ros.spawn(f"topic echo --once --json {topic}") for topic in topics]
    fix, height, pressure, field, touch, scan = (
        json.loads(echo.wait_for_line(r"\{.*").string) for echo in echoes
    )
    partner.close()

    assert (fix["latitude"], fix["longitude"]) == pytest.approx((47.0, 8.0), abs=1e-7)
    assert fix["altitude"] == pytest.approx(400.5, abs=0.01)
    assert height["vertical_position"] == pytest.approx(0.5, abs=0.01)
    # At 400 m above the sea, where the GPS is, a metre of air weighs less than there.
    assert pressure["fluid_pressure"] == pytest.approx(96610, abs=10)
    assert field["magnetic_field"]["z"] == pytest.approx(-42.3884e-6, abs=1e-8)
    (pair,) = touch["contacts"]
    weight = sum(wrench["body_1_wrench"]["force"]["z"] for wrench in pair["wrenches"])
    assert weight == pytest.approx(9.81, rel=0.01)
    slant = 0.5 / math.cos(0.5)
    assert scan["ranges"] == pytest.approx([slant, 0.5, slant], abs=2e-3)


def xyz(message) -> tuple[float, float, float]:
    acceleration = message.linear_acceleration
    return acceleration.x, acceleration.y, acceleration.z


@pytest.mark.nightly
def test_what_is_killed_in_motion_comes_back_to_work_where_that_is_asked(ros: RosGraph) -> None:
    """The manager, the publisher of frames and the spawner, while the arm is on its way."""
    ros.launch("sim.yaml", "camera:=false", "world:=", "respawn:=true")
    trajectory = get_message("trajectory_msgs/msg/JointTrajectory")
    point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
    publisher = ros.node.create_publisher(trajectory, "/arm_controller/joint_trajectory", 10)

    def go(joint_1: float, seconds: int, there: Callable[[float, float], bool]) -> None:
        """Send the arm somewhere, again while it stands still, until it is there."""
        goal = point(positions=[joint_1, 0.0, 0.0])
        goal.time_from_start.sec = seconds
        message = trajectory(joint_names=["joint_1", "joint_2", "joint_3"], points=[goal])

        def look(state: Any) -> bool:
            index = state.name.index("joint_1")
            position, velocity = state.position[index], state.velocity[index]
            if abs(velocity) < 1e-3:
                publisher.publish(message)
            return there(position, velocity)

        ros.wait_for_message(
            get_message("sensor_msgs/msg/JointState"), "/mujoco_sim/joint_states", look
        )

    def pids() -> dict[str, int]:
        processes = json.loads(ros.run("ps --json").stdout)
        return {process["name"].rpartition("-")[0]: process["pid"] for process in processes}

    def controllers() -> list[str]:
        listed = ros.run("control list_controllers --json").stdout
        return [one["state"] for one in json.loads(listed or "[]")]

    go(1.5, 60, lambda position, velocity: position > 0.01 and velocity > 0.01)
    before = pids()
    victims = ("ros2_control_node", "robot_state_publisher", "spawner")
    for name in victims:
        psutil.Process(before[name]).kill()

    def they_are_back() -> bool:
        now = pids()
        return all(now.get(name, before[name]) != before[name] for name in victims)

    eventually(they_are_back)
    eventually(lambda: controllers() == ["active"] * 3)
    go(-0.2, 1, lambda position, _: abs(position + 0.2) < 0.01)
    ros.wait_for_nodes("/robot_state_publisher")
    assert pids()["mujoco_sim"] == before["mujoco_sim"]


@pytest.mark.nightly
def test_it_quits_when_asked_also_by_a_clock_that_stands_still(
    ros: RosGraph, partner: Partner
) -> None:
    sim = start(ros, "paused:=true", "use_sim_time:=true")
    sim.wait_for_line("Simulation is paused")
    kind = get_service("simulation_interfaces/srv/SetSimulationState")
    request = kind.Request()
    request.state.state = request.state.STATE_QUITTING
    client = partner.create_client(kind, "/set_simulation_state")
    assert client.wait_for_service(LONGEST_WAIT_S)
    answer: Any = client.call(request, timeout_sec=LONGEST_WAIT_S)
    assert answer.result.result == 1
    assert sim.wait() == 0
