"""The controller manager and the simulator, in lockstep."""

import threading

import pytest

from teleopctl.interfaces.store import get_message, get_service
from teleopctl.node import Context, Node, qos_profile_latched
from teleopctl.packages import package_share
from teleopctl.robot.xacro.expansion import expand_xacro
from teleopctl.testing import LONGEST_WAIT_S, eventually

MODEL = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
CONTROLLERS = package_share("teleop_controller") / "teleop_controllers.yaml"
ALL = "joint_state_broadcaster arm_controller gripper_controller"

JointState = get_message("sensor_msgs/msg/JointState")
JointTrajectory = get_message("trajectory_msgs/msg/JointTrajectory")
JointTrajectoryPoint = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
Float64MultiArray = get_message("std_msgs/msg/Float64MultiArray")
Duration = get_message("builtin_interfaces/msg/Duration")
String = get_message("std_msgs/msg/String")
ResetSimulation = get_service("simulation_interfaces/srv/ResetSimulation")
SetPause = get_service("mujoco_ros2_control_msgs/srv/SetPause")


def start_manager(ros):
    return ros.spawn_module(
        "teleopctl.nodes",
        f"controller_manager ros2_control_node --ros-args --params-file {CONTROLLERS}",
    )


class Operator(Node):
    """Describes the robot, commands it and writes down every joint state."""

    def __init__(self, ros, urdf, *, sim_rate=10, hosted=False):
        self._own = Context()
        self._own.init([])
        super().__init__("operator", context=self._own, start_parameter_services=False)
        self._changed = threading.Condition()
        self.states = []
        self.create_publisher(String, "/robot_description", qos_profile_latched).publish(
            String(data=urdf)
        )
        self.sim = ros.spawn_module(
            "teleopctl.nodes",
            ["mujoco_sim", "mujoco_sim"]
            + [f"--controller-manager=--ros-args --params-file {CONTROLLERS}"] * hosted
            + ["--ros-args", "-p", "paused:=true", "-p", "real_time_factor:=0"]
            + ["-p", f"update_rate:={sim_rate}"],
        )
        self.manager = self.sim if hosted else start_manager(ros)
        # In one process either may come first.
        eventually(lambda: "Simulation is paused" in self.sim.stderr)
        eventually(lambda: "Starting Controller Manager services" in self.manager.stderr)
        self.create_subscription(JointState, "/joint_states", self._heard, 10, immediate=True)

    def _heard(self, message):
        with self._changed:
            self.states.append(message)
            self._changed.notify_all()

    def wait_until(self, what):
        with self._changed:
            enough = self._changed.wait_for(what, LONGEST_WAIT_S)
            assert enough, f"{len(self.states)} states\n{self.sim.stderr}\n{self.manager.stderr}"

    def wait_for_states(self, count):
        self.wait_until(lambda: len(self.states) >= count)
        return self.states[:count]

    def pause(self, paused):
        client = self.create_client(SetPause, "/mujoco_sim/set_pause")
        assert client.wait_for_service(LONGEST_WAIT_S)
        response = client.call(SetPause.Request(paused=paused), LONGEST_WAIT_S)
        assert response is not None
        assert response.success

    def reset(self):
        client = self.create_client(ResetSimulation, "/reset_simulation")
        assert client.wait_for_service(LONGEST_WAIT_S)
        response = client.call(ResetSimulation.Request(), LONGEST_WAIT_S)
        assert response is not None and response.result.result == 1, response

    def send(self, topic, message):
        publisher = self.create_publisher(type(message), topic, 10)
        assert self.wait_for_subscribers(topic, 1, LONGEST_WAIT_S)
        publisher.publish(message)

    def command_both(self):
        """Open the gripper and move the arm, while time stands still."""
        point = JointTrajectoryPoint(
            positions=[0.5, -0.3, 0.4], time_from_start=Duration(nanosec=500_000_000)
        )
        joints = ["joint_1", "joint_2", "joint_3"]
        self.send(
            "/arm_controller/joint_trajectory", JointTrajectory(joint_names=joints, points=[point])
        )
        self.send("/gripper_controller/commands", Float64MultiArray(data=[-1.0]))
        for controller in ("arm_controller", "gripper_controller"):
            self._wait_until_served(controller)

    def _wait_until_served(self, controller):
        """Its node answers one request at a time, so what came before has been taken."""
        kind = get_service("control_msgs/srv/QueryTrajectoryState")
        client = self.create_client(kind, f"/{controller}/query_state")
        assert client.wait_for_service(LONGEST_WAIT_S)
        assert client.call(kind.Request(), LONGEST_WAIT_S) is not None

    def close(self):
        for process in dict.fromkeys((self.sim, self.manager)):
            process.interrupt()
            assert process.wait() == 0
        self._own.try_shutdown()


@pytest.fixture(scope="module")
def urdf():
    return expand_xacro(MODEL, {"hardware": "sim"})


def run(ros, urdf, count, *, hosted=False):
    """Joint states of the first cycles after both commands were given."""
    operator = Operator(ros, urdf, hosted=hosted)
    spawned = ros.run_module("teleopctl.nodes", f"controller_manager spawner {ALL}")
    assert spawned.returncode == 0, spawned.stderr
    operator.command_both()
    operator.pause(False)
    states = operator.wait_for_states(count)
    report = operator.sim.stderr + operator.manager.stderr
    operator.close()
    return states, report


@pytest.mark.nightly
def test_two_runs_with_the_same_commands_are_byte_for_byte_the_same(ros, urdf):
    first, report = run(ros, urdf, 40)
    second, _ = run(ros, urdf, 40)

    def raw(states):
        return [
            (s.header.stamp.sec, s.header.stamp.nanosec, list(s.name), s.position.tobytes())
            for s in states
        ]

    assert raw(first) == raw(second)
    stamps = [s.header.stamp.sec * 10**9 + s.header.stamp.nanosec for s in first]
    assert stamps == [stamps[0] + 100_000_000 * tick for tick in range(40)]
    final = dict(zip(first[-1].name, first[-1].position, strict=True))
    wanted = {"joint_1": 0.5, "joint_2": -0.3, "joint_3": 0.4, "joint_4": -1.0, "joint_5": 1.0}
    assert final == pytest.approx(wanted, abs=2e-3)
    warnings = [line for line in report.splitlines() if "WARN" in line and "mujoco_sim" in line]
    assert all("Desired controller update period" in line for line in warnings), warnings


@pytest.mark.nightly
def test_controllers_are_switched_while_time_stands_still(ros, urdf):
    operator = Operator(ros, urdf)
    assert ros.run_module("teleopctl.nodes", f"controller_manager spawner {ALL}").returncode == 0
    result = ros.run("control set_controller_state arm_controller inactive")
    assert result.returncode == 0, result.stderr
    operator.pause(False)
    operator.wait_for_states(3)
    operator.pause(True)
    result = ros.run("control set_controller_state arm_controller active")
    assert result.returncode == 0, result.stderr
    count = len(operator.states)
    operator.pause(False)
    operator.wait_for_states(count + 3)
    operator.close()


@pytest.mark.nightly
def test_a_simulator_with_another_rate_is_told(ros, urdf):
    operator = Operator(ros, urdf, sim_rate=50)
    operator.pause(False)
    operator.manager.wait_for_line(
        r"States come every 0.02 s, but 'update_rate' is 10 Hz, a cycle every 0.1 s"
    )
    operator.close()


@pytest.mark.nightly
def test_a_manager_that_begins_anew_takes_the_arm_over_where_it_is(ros, urdf):
    operator = Operator(ros, urdf)
    assert ros.run_module("teleopctl.nodes", f"controller_manager spawner {ALL}").returncode == 0
    operator.command_both()
    operator.pause(False)
    operator.wait_for_states(20)
    operator.pause(True)
    operator.manager.kill()
    operator.manager = start_manager(ros)
    operator.manager.wait_for_line("Starting Controller Manager services")
    # While time stands still, nothing has been measured yet.
    assert ros.run_module("teleopctl.nodes", f"controller_manager spawner {ALL}").returncode == 0
    before = operator.states[-1].position
    count = len(operator.states)
    operator.pause(False)
    after = operator.wait_for_states(count + 5)[-1].position
    assert list(after) == pytest.approx(list(before), abs=1e-3)
    operator.close()


@pytest.mark.nightly
def test_a_reset_while_time_stands_still_is_published_by_the_broadcasters(ros, urdf):
    operator = Operator(ros, urdf)
    assert ros.run_module("teleopctl.nodes", f"controller_manager spawner {ALL}").returncode == 0
    operator.command_both()
    operator.pause(False)
    assert max(operator.wait_for_states(30)[-1].position) > 0.1
    operator.pause(True)
    operator.states = []

    def from_start():
        stamps = [(s.header.stamp.sec, s.header.stamp.nanosec) for s in operator.states]
        return operator.states[stamps.index((0, 0)) :] if (0, 0) in stamps else []

    operator.reset()

    operator.wait_until(lambda: len(from_start()) == 1)
    assert max(map(abs, from_start()[0].position)) < 1e-9
    # What has been shown once is not exchanged again: the next cycle is that of the next tick.
    operator.pause(False)
    operator.wait_until(lambda: len(from_start()) >= 3)
    assert [s.header.stamp.nanosec for s in from_start()[:3]] == [0, 100_000_000, 200_000_000]
    operator.close()
