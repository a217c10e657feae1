"""The controller manager, its spawners and ``teleopctl control``, as real processes."""

import json
import queue
import re
from typing import Any

import pytest

from teleopctl.interfaces.store import get_message
from teleopctl.node import Context, Node, qos_profile_latched
from teleopctl.packages import package_share
from teleopctl.robot.xacro.expansion import expand_xacro
from teleopctl.testing import LONGEST_WAIT_S, Process, eventually
from tests.samples import sample

MODEL = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
CONTROLLERS = package_share("teleop_controller") / "teleop_controllers.yaml"
ALL = ["joint_state_broadcaster", "arm_controller", "gripper_controller"]
CHAIN = f"controller_manager spawner {' '.join(ALL)}"

String = get_message("std_msgs/msg/String")
JointState = get_message("sensor_msgs/msg/JointState")

GONE = """
from teleopctl.control import HardwareComponentInterface

class Bus(HardwareComponentInterface):
    def read(self, time_ns, period):
        raise OSError("the bus is gone")
"""


class Robot(Node):
    """Publishes the robot description and listens, in this process."""

    manager: Process

    def __init__(self):
        self._own = Context()
        self._own.init([])
        super().__init__("robot", context=self._own, start_parameter_services=False)
        self._description = self.create_publisher(String, "/robot_description", qos_profile_latched)
        self.states: queue.Queue[Any] = queue.Queue()

    def describe(self, text):
        self._description.publish(String(data=text))

    def listen(self):
        self.create_subscription(JointState, "/joint_states", self.states.put, 10, immediate=True)

    def wait_for_positions(self, **wanted):
        """Wait until joints are measured near the wanted positions, rad."""
        while True:
            state = self.states.get(timeout=LONGEST_WAIT_S)
            measured = dict(zip(state.name, state.position, strict=True))
            if all(abs(measured[name] - value) < 1e-3 for name, value in wanted.items()):
                return state

    def close(self):
        self._own.try_shutdown()


@pytest.fixture(scope="module")
def mock_urdf():
    return expand_xacro(MODEL, {"hardware": "mock"})


def start_manager(ros, *arguments):
    return ros.spawn_module(
        "teleopctl.nodes",
        [
            "controller_manager",
            "ros2_control_node",
            "--ros-args",
            "--params-file",
            str(CONTROLLERS),
            *arguments,
        ],
    )


def spawn(ros, arguments):
    return ros.run_module("teleopctl.nodes", f"controller_manager spawner {arguments}")


def lines(result):
    return result.stdout.splitlines()


@pytest.fixture(scope="module")
def looked_at(shared_ros, mock_urdf):
    """A running chain for tests that only look."""
    robot = Robot()
    robot.describe(mock_urdf)
    manager = start_manager(shared_ros)
    result = spawn(shared_ros, " ".join(ALL))
    assert result.returncode == 0, result.stderr
    yield shared_ros, manager, result
    robot.close()


@pytest.fixture
def robot(ros, mock_urdf):
    """A described robot whose controller manager runs and has no controllers yet."""
    node = Robot()
    node.describe(mock_urdf)
    node.manager = start_manager(ros)
    node.manager.wait_for_line("Starting Controller Manager services")
    yield node
    node.close()


class TestLooking:
    def test_the_spawner_says_what_it_did(self, looked_at):
        _, _, spawner = looked_at
        said = [line.partition("]: ")[2] for line in spawner.stderr.splitlines()]
        for name in ALL:
            assert f"Loaded {name}" in said
            assert f"Configured and activated {name}" in said

    def test_the_manager_says_what_it_did(self, looked_at):
        _, manager, _ = looked_at
        said = manager.stderr
        for text in (
            "update rate is 10 Hz",
            "Received robot description from topic.",
            "Loaded hardware 'RobotSystem' from plugin 'mock_components/GenericSystem'",
            "Successful initialization of hardware 'RobotSystem'",
            "Successful 'configure' of hardware 'RobotSystem'",
            "Successful 'activate' of hardware 'RobotSystem'",
            "Loading controller 'arm_controller'",
            "Configuring controller: 'arm_controller'",
            "Activating controllers: [ arm_controller ]",
            "Successfully switched controllers!",
        ):
            assert text in said

    def test_list_controllers(self, looked_at):
        ros, _, _ = looked_at
        trajectory = "joint_trajectory_controller/JointTrajectoryController"
        assert lines(ros.run("control list_controllers")) == [
            "joint_state_broadcaster joint_state_broadcaster/JointStateBroadcaster          active",
            f"arm_controller          {trajectory}  active",
            f"gripper_controller      {trajectory}  active",
        ]

    @pytest.mark.parametrize(
        ("wish", "name", "state"),
        [
            ("FORCE_COLOR", "\x1b[92marm_controller         \x1b[0m", "\x1b[92mactive\x1b[0m"),
            ("NO_COLOR", "arm_controller         ", "active"),
        ],
    )
    def test_list_controllers_is_coloured_by_state(self, looked_at, monkeypatch, wish, name, state):
        ros, _, _ = looked_at
        monkeypatch.setitem(ros.env, wish, "1")
        arm = lines(ros.run("control list_controllers"))[1]
        assert arm == f"{name} joint_trajectory_controller/JointTrajectoryController  {state}"

    def test_list_controllers_with_interfaces(self, looked_at):
        ros, _, _ = looked_at
        text = ros.run("control list_controllers --claimed-interfaces").stdout
        assert "\tclaimed interfaces:\n\t\tjoint_1/position\n\t\tjoint_2/position\n" in text
        verbose = ros.run("control list_controllers -v").stdout
        assert "\tupdate_rate: 10 Hz\n\tis_async: False\n" in verbose

    def test_list_hardware_components(self, looked_at):
        ros, _, _ = looked_at
        assert lines(ros.run("control list_hardware_components")) == [
            "Hardware Component 1",
            "\tname: RobotSystem",
            "\ttype: system",
            "\tplugin name: mock_components/GenericSystem",
            "\tstate: id=3 label=active",
            "\tread/write rate: 10 Hz",
            "\tis_async: False",
            "\tcommand interfaces",
            *(f"\t\tjoint_{n}/position [available] [claimed]" for n in range(1, 5)),
        ]
        verbose = lines(ros.run("control list_hardware_components -v"))
        assert "\t\tjoint_1/position [double] [available] [claimed]" in verbose
        assert "\t\tjoint_5/position [double] [available]" in verbose

    def test_list_hardware_interfaces(self, looked_at):
        ros, _, _ = looked_at
        assert lines(ros.run("control list_hardware_interfaces")) == [
            "command interfaces",
            *(f"\tjoint_{n}/position [available] [claimed]" for n in range(1, 5)),
            "state interfaces",
            *(f"\tjoint_{n}/position" for n in range(1, 6)),
        ]

    def test_list_controller_types(self, looked_at):
        ros, _, _ = looked_at
        name = "joint_trajectory_controller/JointTrajectoryController"
        base = "controller_interface::ControllerInterface"
        assert f"{name:70} {base}" in lines(ros.run("control list_controller_types"))

    @pytest.mark.parametrize(
        "verb", ["list_controllers", "list_hardware_components", "list_hardware_interfaces"]
    )
    def test_lists_as_json(self, looked_at, verb):
        ros, _, _ = looked_at
        assert json.loads(ros.run(f"control {verb} --json").stdout)

    def test_the_chain_of_interfaces_and_controllers_is_drawn(
        self, looked_at, monkeypatch, tmp_path
    ):
        ros, _, _ = looked_at
        monkeypatch.setitem(ros.env, "PATH", str(tmp_path))  # no dot there
        monkeypatch.setitem(ros.env, "TMPDIR", str(tmp_path))
        done = ros.run("control view_controller_chains")
        files = [f"{tmp_path}/controller_diagram.{ending}" for ending in ("gv", "svg")]
        assert lines(done) == files, done.stderr
        graph = (tmp_path / "controller_diagram.gv").read_text()
        arm = '"controller arm_controller"'
        assert f'"state joint_1/position" -> {arm};' in graph
        assert f'{arm} -> "command joint_1/position";' in graph
        assert "arm_controller" in (tmp_path / "controller_diagram.svg").read_text()

    def test_controllers_are_nodes_with_parameters(self, looked_at):
        ros, _, _ = looked_at
        nodes = lines(ros.run("node list"))
        assert {"/controller_manager", *(f"/{name}" for name in ALL)} <= set(nodes)
        result = ros.run("param get /arm_controller joints")
        assert result.stdout.strip() == "String values are: ['joint_1', 'joint_2', 'joint_3']"

    def test_an_absent_manager_is_named_and_the_present_one_too(self, looked_at):
        ros, _, _ = looked_at
        result = ros.run("control list_controllers -c other")
        assert result.returncode == 1
        assert result.stdout == ""
        assert "/other" in result.stderr
        assert "/controller_manager" in result.stderr

    def test_the_namespace_of_the_node_that_asks_is_that_of_the_manager(self, looked_at):
        ros, _, _ = looked_at
        result = ros.run("control list_controllers --ros-args -r __ns:=/left")
        assert (result.returncode, result.stdout) == (1, "")
        assert "/left/controller_manager" in result.stderr
        # The shortened option is Typer's to read, the rest of the line all the same.
        result = ros.run(
            "control list_controller_types --controller-m /controller_manager "
            "--ros-args -r __ns:=/left -r __node:=me"
        )
        assert "joint_trajectory_controller/JointTrajectoryController" in result.stdout
        result = ros.run("control list_controllers --ros-args -r left")
        assert (result.returncode, result.stdout) == (2, "")
        assert "left" in result.stderr

    def test_the_doctor_finds_nothing_and_a_controller_that_is_not_there(self, looked_at):
        ros, _, _ = looked_at
        well = ros.run("control doctor")
        assert (well.returncode, well.stdout, well.stderr) == (0, "\nAll 8 checks passed\n\n", "")
        ill = ros.run("control doctor arm_controler")
        assert (ill.returncode, ill.stdout) == (
            1,
            "\n1/8 check(s) failed\n\nFailed modules: controllers\n",
        )
        assert ill.stderr == (
            f"teleopctl: Controller 'arm_controler' is not loaded; loaded are {', '.join(ALL)}. "
            "Did you mean arm_controller?\n"
            "  teleopctl run controller_manager spawner arm_controler --param-file FILE\n"
        )
        absent = ros.run("control doctor -c /nobody")
        assert (absent.returncode, "running: /controller_manager" in absent.stderr) == (1, True)

    def test_an_unknown_controller_is_named(self, looked_at):
        ros, _, _ = looked_at
        result = ros.run("control set_controller_state nobody active")
        assert (result.returncode, result.stdout) == (1, "")
        assert "controller nobody does not seem to be loaded" in result.stderr

    def test_a_second_manager_of_the_same_name_is_refused(self, looked_at):
        ros, _, _ = looked_at
        second = start_manager(ros)
        assert second.wait() == 1
        assert "A node named /controller_manager is already running" in second.stderr

    def test_a_simulator_for_gazebos_launch_files_leaves_the_robot_to_the_one_that_runs(
        self, looked_at
    ):
        ros, _, _ = looked_at
        options = ["--controller-manager=--ros-args", "--unless-running"]
        simulator = ros.spawn_module("teleopctl.nodes", ["mujoco_sim", "mujoco_sim", *options])
        simulator.wait_for_line("this name runs already: it controls the robot")
        simulator.interrupt()
        assert simulator.wait() == 0

    def test_active_controllers_are_spawned_again_only_on_request(self, looked_at):
        ros, _, _ = looked_at
        assert spawn(ros, "arm_controller").returncode == 1
        again = spawn(ros, f"{' '.join(ALL)} --allow-active --param-file {CONTROLLERS}")
        assert again.returncode == 0
        assert "Controller already loaded, skipping load_controller" in again.stderr
        loaded = ros.run("control load_controller arm_controller")
        skipped = "Controller : arm_controller already loaded, skipping load_controller!\n"
        assert (loaded.stdout.startswith(skipped), loaded.returncode) == (True, 0)
        nameless = ros.run("control set_hardware_component_state RobotSystme active")
        assert nameless.stderr == (
            "teleopctl: Error activating hardware component, check controller_manager logs\n"
            "  Did you mean RobotSystem?\n"
        )

    @pytest.mark.nightly
    def test_the_others_come_up_beside_those_that_cannot_where_that_is_wanted(
        self, looked_at, tmp_path
    ):
        ros, _, _ = looked_at
        own = tmp_path / "own.yaml"
        own.write_text(
            "second: {ros__parameters: {type: position_controllers/JointGroupPositionController,"
            " joints: [joint_1]}}\n"
            "vendors: {ros__parameters: {type: vendor/Special}}\n"
        )
        done = spawn(ros, f"vendors second --param-file {own} --keep-going")
        for status, words in (
            (0, "Unloaded controller"),
            (1, "Failed to unload controller: Could not unload controller with name 'second' "
                "because no controller with this name exists"),
        ):  # fmt: skip
            gone = ros.run_module("teleopctl.nodes", "controller_manager unspawner second")
            assert (gone.returncode, gone.stderr.partition("]: ")[2]) == (status, f"{words}\n")
        assert done.returncode == 0
        assert (
            f"Controller vendors is left out: its type 'vendor/Special' ({own}:2) is unknown. "
            in done.stderr
        )
        assert (
            "Controller second stays inactive: arm_controller commands joint_1/position. To swap "
            "them: teleopctl control switch_controllers --deactivate arm_controller --activate "
            "second\n"
        ) in done.stderr
        alone = spawn(ros, f"vendors --param-file {own}")
        assert alone.returncode == 1
        assert "(type 'vendor/Special') not found" in alone.stderr


class TestMoving:
    def test_the_gripper_opens_and_its_mimic_joint_follows(self, ros, robot):
        assert spawn(ros, " ".join(ALL)).returncode == 0
        robot.listen()
        topic = "topic pub --once /gripper_controller/commands std_msgs/msg/Float64MultiArray"
        assert ros.run([*topic.split(), "{data: [-1]}"]).returncode == 0
        robot.wait_for_positions(joint_4=-1.0, joint_5=1.0)
        assert ros.run([*topic.split(), "{data: [0]}"]).returncode == 0
        robot.wait_for_positions(joint_4=0.0, joint_5=0.0)
        assert ros.run([*topic.split(), "{data: [-2]}"]).returncode == 0
        state = robot.wait_for_positions(joint_4=-1.5708)
        assert min(state.position) >= -1.5708
        said = robot.manager.stderr
        reports = re.findall(r"Command of joint 'joint_4' is outside its limits.*", said)
        (report,) = reports
        assert "position -2 is clamped to -1.5708 (position limits [-1.5708, 0], line " in report

    def test_the_arm_follows_a_trajectory(self, ros, robot):
        assert spawn(ros, " ".join(ALL)).returncode == 0
        robot.listen()
        message = (
            "{joint_names: [joint_1, joint_2, joint_3], points: [{positions: [0.5, -0.3, 0.4], "
            "time_from_start: {sec: 0, nanosec: 500000000}}]}"
        )
        kind = "trajectory_msgs/msg/JointTrajectory"
        words = ["topic", "pub", "--once", "/arm_controller/joint_trajectory", kind, message]
        assert ros.run(words).returncode == 0
        robot.wait_for_positions(joint_1=0.5, joint_2=-0.3, joint_3=0.4)

    def test_controllers_are_switched_from_the_command_line(self, ros, robot):
        assert spawn(ros, " ".join(ALL)).returncode == 0
        result = ros.run("control set_controller_state arm_controller inactive")
        assert result.stdout == "Successfully deactivated arm_controller\n"
        result = ros.run("control cleanup_controller arm_controller")
        assert result.stdout == "Successfully cleaned up controller arm_controller\n"
        result = ros.run("control unload_controller arm_controller")
        assert result.stdout == "Successfully unloaded controller arm_controller\n"
        result = ros.run("control load_controller arm_controller --set-state active")
        assert result.stdout.splitlines() == [
            "Successfully loaded controller arm_controller",
            "Successfully loaded controller arm_controller into state active",
        ]
        result = ros.run(
            "control switch_controllers --strict --deactivate arm_controller "
            "--deactivate gripper_controller"
        )
        assert result.stdout == "Successfully switched controllers!\n"
        both = "arm_controller gripper_controller"
        result = ros.run(f"control switch_controllers --activate {both} --strict")
        assert result.stdout == "Successfully switched controllers!\n", result.stderr
        result = ros.run("control switch_controllers --strict --activate nobody")
        assert result.returncode == 1
        assert "no controller with this name exists" in result.stderr
        result = ros.run_module("teleopctl.nodes", f"controller_manager unspawner {' '.join(ALL)}")
        assert result.returncode == 0, result.stderr
        result = ros.run("control reload_controller_libraries")
        assert result.stdout == "Reload successful\n"
        result = ros.run("control list_controllers")
        assert result.stdout == "No controllers are currently loaded!\n"


class TestSpawner:
    def test_no_type_fails_and_loads_nothing(self, ros, robot):
        del robot
        result = spawn(ros, "unheard_of")
        assert result.returncode == 1
        assert "Failed loading controller unheard_of" in result.stderr
        assert "No controllers" in ros.run("control list_controllers").stdout

    def test_a_missing_manager_ends_a_bounded_wait(self, ros):
        result = spawn(ros, "arm_controller --controller-manager-timeout 0.5")
        assert result.returncode == 1
        assert "waiting for service /controller_manager/list_controllers" in result.stderr
        assert "Could not contact service /controller_manager/list_controllers" in result.stderr

    @pytest.mark.parametrize("stop", ["interrupt", "terminate"])
    def test_a_wait_for_the_manager_can_be_ended(self, ros, stop):
        spawner = ros.spawn_module("teleopctl.nodes", CHAIN)
        spawner.wait_for_line("waiting for service")
        getattr(spawner, stop)()
        assert spawner.wait() != 0
        assert spawner.stderr.count("waiting for service") == 1
        assert "Traceback" not in spawner.stderr

    @pytest.mark.parametrize(
        "wrong", sample(["joints: joint_1", "update_rate: fast", "update_rate: -5", "{"], 4)
    )
    def test_wrong_parameters_stop_that_controller_and_not_the_manager(
        self, ros, robot, tmp_path, wrong
    ):
        del robot
        file = tmp_path / "wrong.yaml"
        kind = "joint_trajectory_controller/JointTrajectoryController"
        file.write_text(
            f"{{wrong: {{ros__parameters: {{type: {kind}, command_interfaces: [position], "
            f"state_interfaces: [position], joints: [joint_1], {wrong}}}}}}}"
        )
        result = spawn(ros, f"wrong --param-file {file}")
        assert result.returncode == 1
        assert "Traceback" not in result.stderr
        assert spawn(ros, "joint_state_broadcaster").returncode == 0

    def test_a_refused_description_ends_the_wait_of_spawners_until_another_is_taken(
        self, ros, mock_urdf
    ):
        robot = Robot()
        manager = start_manager(ros)
        waiting = ros.spawn_module("teleopctl.nodes", CHAIN)
        waiting.wait_for_line("waiting for service")
        robot.describe("<robot>")
        manager.wait_for_line("robot description file .* seems not to be genuine")
        cause = "/controller_manager has not accepted the robot description: "
        assert waiting.wait() == 1
        assert cause in waiting.stderr
        late = spawn(ros, ALL[0])
        assert late.returncode == 1
        assert cause in late.stderr
        robot.describe(mock_urdf)
        assert spawn(ros, ALL[0]).returncode == 0
        robot.close()

    def test_who_cannot_load_or_configure_a_controller_is_told_the_managers_reason(
        self, ros, robot, tmp_path
    ):
        del robot
        file = tmp_path / "wrong.yaml"
        kind = "joint_trajectory_controller/JointTrajectoryController"
        file.write_text(f"{{wrong: {{ros__parameters: {{type: {kind}, joints: [nope]}}}}}}")
        untyped = "The 'type' param was not defined for 'nope'."
        assert f"Failed loading controller nope: {untyped}" in spawn(ros, "nope").stderr
        assert untyped in ros.run("control load_controller nope").stderr
        spawned = spawn(ros, f"wrong --param-file {file}").stderr
        reason = spawned.partition("Failed to configure controller: ")[2].splitlines()[0]
        assert reason
        again = ros.run("control set_controller_state wrong inactive").stderr
        assert reason in again

    @pytest.mark.nightly
    def test_a_spawner_waits_for_the_robot_description(self, ros, mock_urdf):
        robot = Robot()
        manager = start_manager(ros)
        manager.wait_for_line("Waiting for data on 'robot_description' topic")
        spawner = ros.spawn_module("teleopctl.nodes", CHAIN)
        spawner.wait_for_line("waiting for service")
        robot.describe(mock_urdf)
        assert spawner.wait() == 0
        robot.describe(mock_urdf)
        manager.wait_for_line("has already loaded a urdf")
        manager.interrupt()
        assert manager.wait() == 0
        robot.close()

    def test_without_handle_exceptions_an_exception_of_hardware_ends_the_manager(
        self, ros, mock_urdf
    ):
        (ros.folder / "gone.py").write_text(GONE)
        robot = Robot()
        robot.describe(mock_urdf.replace("mock_components/GenericSystem", "gone:Bus"))
        ros.env["PYTHONPATH"] = str(ros.folder)
        manager = start_manager(ros, "-p", "handle_exceptions:=false")
        del ros.env["PYTHONPATH"]
        assert manager.wait() == 1
        reason = rf"raised in read: OSError: the bus is gone \({ros.folder}/gone.py:\d+\)"
        assert re.search(rf"\nHardware 'RobotSystem' {reason}\n", manager.stderr)
        assert re.search(r"FATAL.*Traceback.*OSError: the bus is gone", manager.stderr, re.DOTALL)
        robot.close()

    @pytest.mark.parametrize("stop", sample(["interrupt", "terminate"], 2))
    def test_what_was_spawned_can_be_unloaded_with_the_spawner(self, ros, robot, stop):
        del robot
        spawner = ros.spawn_module("teleopctl.nodes", f"{CHAIN} --unload-on-kill")
        spawner.wait_for_line("Waiting until interrupt to unload controllers")
        getattr(spawner, stop)()
        spawner.wait_for_line("Successfully unloaded controllers")
        assert spawner.wait() == 0
        assert "No controllers" in ros.run("control list_controllers").stdout

    def test_as_a_group(self, ros, robot):
        result = spawn(ros, f"{' '.join(ALL)} --activate-as-group")
        assert result.returncode == 0
        expected = f"Configured and activated all the parsed controllers list : {ALL}!"
        assert expected in result.stderr
        robot.manager.wait_for_line(
            r"Activating controllers: \[ joint_state_broadcaster arm_controller "
        )


@pytest.mark.nightly
def test_statistics_and_diagnostics_come_for_those_who_listen(ros):
    ros.launch("controller.yaml", "hardware:=mock")
    named = ros.wait_for_message(
        get_message("pal_statistics_msgs/msg/StatisticsNames"),
        "/controller_manager/statistics/names",
        lambda message: "arm_controller.stats/execution_time/average" in message.names,
        qos=qos_profile_latched,
    )
    values = ros.wait_for_message(
        get_message("pal_statistics_msgs/msg/StatisticsValues"),
        "/controller_manager/statistics/values",
        lambda message: message.names_version == named.names_version,
    )
    assert len(values.values) == len(named.names)
    full = ros.wait_for_message(
        get_message("pal_statistics_msgs/msg/Statistics"), "/controller_manager/statistics/full"
    )
    assert [one.name for one in full.statistics] == list(named.names)
    told = ros.wait_for_message(get_message("diagnostic_msgs/msg/DiagnosticArray"), "/diagnostics")
    assert [(one.name, one.hardware_id) for one in told.status] == [
        (f"controller_manager: {task} Activity", "ros2_control")
        for task in ("Controllers", "Hardware Components", "Controller Manager")
    ]


class TestHardwareStatus:
    """What ros2_control reports from Lyrical on, in types that this distribution lacks."""

    @pytest.fixture
    def reported(self, ros, tmp_path):
        folder = tmp_path / "control_msgs"
        for name, text in (
            ("HardwareStatus", "string hardware_id\nHardwareDeviceStatus[] hardware_device_states"),
            ("HardwareDeviceStatus", "string device_id\nGenericHardwareState[] hardware_status"),
            ("GenericHardwareState", "uint8 health_status"),
        ):
            (folder / "msg").mkdir(parents=True, exist_ok=True)
            (folder / "msg" / f"{name}.msg").write_text(f"std_msgs/Header header\n{text}\n")
        (folder / "package.xml").write_text("<package><name>control_msgs</name></package>")
        ros.env["TELEOPCTL_PACKAGE_PATH"] = str(tmp_path)
        motors = "[{device_id: m1, hardware_status: [{health_status: 1}]}, {device_id: m2}]"
        report = f"{{hardware_id: arm, hardware_device_states: {motors}}}"
        kind = "control_msgs/msg/HardwareStatus"
        ros.spawn(["topic", "pub", "-r", "50", "/cm/hardware_status", kind, report])
        assert ros.run("topic echo --once /cm/hardware_status " + kind).returncode == 0
        return ros

    def test_it_is_printed_by_device(self, reported):
        status = reported.spawn("control view_hardware_status")
        status.wait_for_line("---", stream="stdout")
        said = status.stdout.splitlines()
        assert re.fullmatch(r"Hardware ID: arm \(stamp: \d\d:\d\d:00\.000\)", said[0])
        assert said[1:4] == ["  Device ID: m1", "    Generic Hardware States:", "      -"]
        end = said.index("---")
        assert said[end - 3 : end] == [
            "        health_status: 1",
            "  Device ID: m2",
            "    Status: No specific states reported",
        ]

    def test_an_id_that_nobody_has_is_told(self, reported):
        done = reported.run("control view_hardware_status -i leg")
        assert (done.returncode, done.stdout) == (1, "")
        assert "Hardware ID 'leg' not found.\n  There is arm." in done.stderr


def test_without_hardware_that_reports_there_is_nothing_to_view(ros):
    done = ros.run("control view_hardware_status")
    assert done.returncode == 1
    assert "No topics of type 'control_msgs/msg/HardwareStatus' found." in done.stderr


Bool = get_message("std_msgs/msg/Bool")


def test_the_robot_is_stopped_and_released_from_the_command_line(ros, robot):
    assert spawn(ros, " ".join(ALL)).returncode == 0
    assert lines(ros.run("stop --robot")) == ["The robot is stopped: /controller_manager"]
    robot.manager.wait_for_line("The robot is stopped by /robot_stop")
    # A manager that starts later is stopped too, since a node holds the robot.
    robot.manager.kill()
    again = start_manager(ros)
    again.wait_for_line("The robot is stopped by /robot_stop")
    released = ros.run("stop --robot --release")
    assert lines(released) == ["The robot is released: /controller_manager"]
    again.wait_for_line("The robot is released")
    eventually(lambda: "robot_stop" not in ros.run("ps").stdout)


def test_a_robot_that_another_node_holds_stopped_is_not_released(ros, robot):
    button = robot.create_publisher(Bool, "/stop", qos_profile_latched)
    button.publish(Bool(data=True))
    robot.manager.wait_for_line("The robot is stopped by /robot:")
    refused = ros.run("stop --robot --release")
    assert refused.returncode == 1
    assert "The robot is still stopped by /robot" in refused.stderr
    button.publish(Bool(data=False))
    robot.manager.wait_for_line("The robot is released")


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ("stop --robot arm", "takes no names"),
        ("stop --release", "teleopctl stop --robot --release"),
    ],
)
def test_wrong_uses_of_stop_are_refused(ros, words, problem):
    refused = ros.run(words)
    assert refused.returncode == 2
    assert problem in refused.stderr
