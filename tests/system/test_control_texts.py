"""What the verbs of ``control`` print, character for character as ros2 does, in one session.

The texts are those of the format strings of ros2controlcli and the controller manager (Jazzy). What
the manager says of a refusal stands below the verb's words; in ROS 2 it is in the manager's log.
"""

import re

import pytest

from teleopctl.cli import main
from teleopctl.cli.verbs.control import manager as manager_options
from teleopctl.robot.xacro.expansion import expand_xacro
from tests.system.test_control import MODEL, Robot, start_manager

ARM = "arm_controller          joint_trajectory_controller/JointTrajectoryController  active\n"
STATES = "joint_state_broadcaster joint_state_broadcaster/JointStateBroadcaster          active\n"
JOINTS = [f"joint_{number}/position" for number in range(1, 6)]


def listed(title, names=(), more=""):
    """A list below a controller or a component, indented as ros2controlcli does."""
    return f"\t{title}\n" + "".join(f"\t\t{name}{more}\n" for name in names)


def refused(words, more=""):
    return f"teleopctl: {words}\n{more}"


LOGS = "check controller_manager logs"
COMPONENT = """\
Hardware Component 1
	name: RobotSystem
	type: system
	plugin name: mock_components/GenericSystem
	state: id={state}
	read/write rate: 10 Hz
	is_async: False
"""

# What is typed behind `control`, what it prints, what it says on stderr, and its exit status.
TEXTS = [
    ("list_controllers", "No controllers are currently loaded!\n", "", 0),
    (
        "doctor",
        "\n1/8 check(s) failed\n\nFailed modules: controllers\n",
        refused(
            "No controller is loaded.",
            "  teleopctl launch spawn_controllers.yaml controllers_file:=FILE\n",
        ),
        1,
    ),
    (
        "plot nope",
        "",
        refused("controller nope does not seem to be loaded", "  There are no controllers.\n"),
        1,
    ),
    (
        "reload nope",
        "",
        refused(
            "Could not reload controller 'nope': no controller with this name exists; none is "
            "loaded"
        ),
        1,
    ),
    (
        "load_controller arm_controller nobodys.yaml",
        "",
        refused("Controller parameter file : nobodys.yaml does not exist, Aborting!"),
        1,
    ),
    (
        "load_controller nope",
        "",
        refused(
            f"Failed loading controller nope {LOGS}",
            "  The 'type' param was not defined for 'nope'.\n",
        ),
        1,
    ),
    ("load_controller arm_controller", "Successfully loaded controller arm_controller\n", "", 0),
    (
        "load_controller arm_controller",
        "Controller : arm_controller already loaded, skipping load_controller!\n",
        "",
        0,
    ),
    (
        "set_controller_state am_controler active",
        "",
        refused(
            "controller am_controler does not seem to be loaded", "  Did you mean arm_controller?\n"
        ),
        1,
    ),
    (
        "set_controller_state arm_controller active",
        "",
        refused("cannot activate arm_controller from its current state unconfigured"),
        1,
    ),
    (
        "set_controller_state arm_controller unconfigured",
        "",
        refused("cannot cleanup arm_controller from its current state unconfigured"),
        1,
    ),
    (
        "set_controller_state arm_controller inactive",
        "Successfully configured arm_controller\n",
        "",
        0,
    ),
    (
        "set_controller_state arm_controller inactive",
        "",
        refused("cannot put arm_controller in 'inactive' state from its current state inactive"),
        1,
    ),
    (
        "set_controller_state arm_controller unconfigured",
        "successfully cleaned up arm_controller\n",
        "",
        0,
    ),
    (
        "load_controller joint_state_broadcaster --set-state active",
        "Successfully loaded controller joint_state_broadcaster\n"
        "Successfully loaded controller joint_state_broadcaster into state active\n",
        "",
        0,
    ),
    (
        "load_controller arm_controller --set-state inactive",
        "Controller : arm_controller already loaded, skipping load_controller!\n"
        "Successfully loaded controller arm_controller into state inactive\n",
        "",
        0,
    ),
    (
        "set_controller_state arm_controller active",
        "Successfully activated arm_controller\n",
        "",
        0,
    ),
    (
        "unload_controller arm_controller",
        "",
        refused(
            f"Error unloading controller arm_controller, {LOGS}",
            "  Could not unload controller with name 'arm_controller' because it is still active\n",
        ),
        1,
    ),
    (
        "cleanup_controller arm_controller",
        "",
        refused(
            f"Error cleaning up controller arm_controller, {LOGS}",
            "  Controller 'arm_controller' cannot be cleaned-up from 'active' state.\n",
        ),
        1,
    ),
    ("list_controllers", ARM + STATES, "", 0),
    ("doctor arm_controller", "\nAll 8 checks passed\n\n", "", 0),
    (
        "top --once --window 0.2",
        "/controller_manager, last # s: rates in Hz, times in us\n"
        "NAME RATE SET P50 P99 MAX LONGEST OVERRUNS MISSED LIMITED SAMPLES\n"
        "controller_manager # # # # # # # # - #\n"
        " period error - - # # # # - - - #\n"
        "RobotSystem read # # # # # # # - - #\n"
        "RobotSystem write # # # # # # # - - #\n"
        "arm_controller # # # # # # # - # #\n"
        "joint_state_broadcaster # # # # # # # - # #\n",
        "Measuring /controller_manager for 0.2 s\n",
        0,
    ),
    ("top --window 0", "", refused("--window must be at least 0.1 s, not 0"), 2),
    (
        "plot arm_controller --joints joint_1 --window 0.2",
        "joint_1:\n(drawing)\nNo error (reference - feedback) above 1e-09\n"
        "joint_1  largest error 0 at 0.00 s, rms 0\n",
        "Recording /arm_controller/controller_state for 0.2 s; Ctrl-C ends it earlier\n",
        0,
    ),
    (
        "plot arm_controller --joints elbow",
        "",
        "Recording /arm_controller/controller_state for 5 s; Ctrl-C ends it earlier\n"
        + refused(
            "Controller 'arm_controller' has no joint elbow",
            "  There are joint_1, joint_2, joint_3.\n",
        ),
        1,
    ),
    (
        "plot joint_state_broadcaster",
        "",
        refused(
            "Controller 'joint_state_broadcaster' (joint_state_broadcaster/JointStateBroadcaster, "
            "active) publishes no control_msgs/msg/JointTrajectoryControllerState on "
            "/joint_state_broadcaster/controller_state",
            "  Trajectory controllers do, once they are configured; `teleopctl topic echo TOPIC "
            "--plot FIELD` draws other topics.\n",
        ),
        1,
    ),
    (
        "reload arm_controller",
        "Successfully reloaded controller arm_controller: no file has changed\n",
        "",
        0,
    ),
    (
        "reload_controller_libraries",
        "",
        refused(
            f"Error reloading libraries, {LOGS}",
            "  there are still 2 active controllers: arm_controller, joint_state_broadcaster\n",
        ),
        1,
    ),
    (
        "view_controller_chains -o /nowhere/chains",
        "",
        refused("Cannot write /nowhere/chains.gv: No such file or directory"),
        1,
    ),
    (
        "list_controllers -v",
        ARM
        + "\tupdate_rate: 10 Hz\n\tis_async: False\n"
        + listed("claimed interfaces:", JOINTS[:3])
        + listed("required command interfaces:", JOINTS[:3])
        + listed("required state interfaces:", JOINTS[:3])
        + listed("chained to interfaces:")
        + listed("exported reference interfaces:")
        + listed("exported state interfaces:")
        + STATES
        + "\tupdate_rate: 10 Hz\n\tis_async: False\n"
        + listed("claimed interfaces:")
        + listed("required command interfaces:")
        + listed("required state interfaces:", JOINTS)
        + listed("chained to interfaces:")
        + listed("exported reference interfaces:")
        + listed("exported state interfaces:"),
        "",
        0,
    ),
    (
        "list_controllers --required-command-interfaces",
        ARM
        + listed("required command interfaces:", JOINTS[:3])
        + STATES
        + listed("required command interfaces:"),
        "",
        0,
    ),
    (
        "list_controllers --reference-interfaces",
        ARM
        + listed("exported reference interfaces:")
        + listed("exported state interfaces:")
        + STATES
        + listed("exported reference interfaces:")
        + listed("exported state interfaces:"),
        "WARNING: The '--reference-interfaces' argument is deprecated and will be removed in "
        "future releases. Use '--exported-interfaces' instead.\n",
        0,
    ),
    (
        "list_hardware_components -v",
        COMPONENT.format(state="3 label=active")
        + listed("command interfaces", JOINTS[:3], " [double] [available] [claimed]")
        + f"\t\t{JOINTS[3]} [double] [available] [unclaimed]\n"
        + listed("state interfaces", JOINTS, " [double] [available]"),
        "",
        0,
    ),
    (
        "list_hardware_interfaces",
        "command interfaces\n"
        + "".join(f"\t{name} [available] [claimed]\n" for name in JOINTS[:3])
        + f"\t{JOINTS[3]} [available] [unclaimed]\n"
        + "state interfaces\n"
        + "".join(f"\t{name}\n" for name in JOINTS),
        "",
        0,
    ),
    (
        "list_hardware_interfaces -v",
        "command interfaces\n"
        + "".join(f"\t{name} [double] [available] [claimed]\n" for name in JOINTS[:3])
        + f"\t{JOINTS[3]} [double] [available] [unclaimed]\n"
        + "state interfaces\n"
        + "".join(f"\t{name} [double]\n" for name in JOINTS),
        "",
        0,
    ),
    (
        "switch_controllers --deactivate arm_controller --activate-asap",
        "Successfully switched controllers!\nDeactivated controllers: [ arm_controller ]\n",
        "",
        0,
    ),
    (
        "switch_controllers --activate nope --strict",
        "",
        refused(
            "Could not activate controller with name 'nope' because no controller with this name "
            "exists",
            "  There are arm_controller, joint_state_broadcaster.\n",
        ),
        1,
    ),
    (
        "plot arm_controller",
        "",
        refused(
            "Controller 'arm_controller' is inactive: only an active controller has a reference",
            "  `teleopctl control doctor arm_controller` says how to activate it.\n",
        ),
        1,
    ),
    (
        "switch_controllers",
        "After checking the controllers, no controllers need to be activated or deactivated.\n",
        "",
        0,
    ),
    (
        "set_hardware_component_state RobotSystem inactive",
        "Successfully set RobotSystem to state lifecycle_msgs.msg.State(id=2, label='inactive')\n",
        "",
        0,
    ),
    (
        "set_controller_state arm_controller active",
        "",
        refused(
            f"Error activating controller, {LOGS}",
            "  Unable to activate controller 'arm_controller' since the hardware component "
            "'RobotSystem' of the command interface 'joint_1/position' is in 'inactive' state.\n",
        ),
        1,
    ),
    (
        "set_hardware_component_state RobotSystem unconfigured",
        "Successfully set RobotSystem to state "
        "lifecycle_msgs.msg.State(id=1, label='unconfigured')\n",
        "",
        0,
    ),
    (
        "list_hardware_components",
        COMPONENT.format(state="1 label=unconfigured")
        + listed("command interfaces", JOINTS[:4], " [unavailable] [unclaimed]"),
        "",
        0,
    ),
    (
        "set_hardware_component_state nope inactive",
        "",
        refused(f"Error stopping hardware component, {LOGS}", "  There is RobotSystem.\n"),
        1,
    ),
    (
        "cleanup_controller arm_controller",
        "Successfully cleaned up controller arm_controller\n",
        "",
        0,
    ),
    (
        "unload_controller arm_controller",
        "Successfully unloaded controller arm_controller\n",
        "",
        0,
    ),
    (
        "unload_controller arm_controller",
        "",
        refused(
            f"Error unloading controller arm_controller, {LOGS}",
            "  Could not unload controller with name 'arm_controller' because no controller with "
            "this name exists\n  There is joint_state_broadcaster.\n",
        ),
        1,
    ),
    ("reload_controller_libraries --force-kill", "Reload successful\n", "", 0),
    ("list_controllers", "No controllers are currently loaded!\n", "", 0),
]


@pytest.fixture
def manager(ros):
    """The controller manager of an arm of mock hardware, without controllers."""
    robot = Robot()
    robot.describe(expand_xacro(MODEL, {"hardware": "mock"}))
    start_manager(ros).wait_for_line("Successful 'activate' of hardware")
    yield
    robot.close()


def masked(text):
    """A printed text with # for measured numbers, and without drawings."""
    text = re.sub("┌.*feedback\n", "(drawing)\n", text, flags=re.DOTALL)
    if "RATE" in text:
        text = re.sub(r"( |last )[\d.]+(?=\s)", r"\1#", re.sub(" +", " ", text))
    return text


@pytest.mark.usefixtures("manager")
def test_they_follow_one_another_as_in_a_terminal(capsys, monkeypatch):
    for line, output, errors, status in TEXTS:
        capsys.readouterr()
        words = line.split()
        found = main.run(words if words[0] == "stop" else ["control", *words])
        printed = capsys.readouterr()
        assert (masked(printed.out), printed.err, found) == (output, errors, status), line
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("FORCE_COLOR", "1")
    main.run(["control", "list_hardware_components"])
    main.run(["control", "list_hardware_interfaces"])
    printed = capsys.readouterr().out
    assert printed.startswith("Hardware Component 1\n\tname: \x1b[93mRobotSystem\x1b[0m\n")
    assert "\t\tjoint_1/position \x1b[93m[unavailable]\x1b[0m [unclaimed]\n" in printed
    assert "\t\x1b[93mjoint_1/position [unavailable] [unclaimed]\x1b[0m\n" in printed


# Every verb that calls the manager, with the words that it needs.
VERBS = (
    "list_controllers",
    "list_controller_types",
    "list_hardware_components",
    "list_hardware_interfaces",
    "load_controller arm",
    "unload_controller arm",
    "cleanup_controller arm",
    "set_controller_state arm active",
    "switch_controllers --activate arm",
    "set_hardware_component_state arm active",
    "reload_controller_libraries",
    "reload arm",
    "plot arm",
    "view_controller_chains",
    "top",
)


@pytest.mark.usefixtures("ros")
def test_without_a_manager_all_say_how_to_start_one(capsys, monkeypatch):
    monkeypatch.setattr(manager_options, "_WAIT", 0.01)
    nobody = refused(
        "Could not contact service /controller_manager/list_controllers",
        "  no controller manager is running: start one with `teleopctl launch controller.yaml` or "
        "`teleopctl launch sim.yaml`\n",
    )
    failed = "\n1/8 check(s) failed\n\nFailed modules: services\n"
    for line, output in (*((verb, "") for verb in VERBS), ("doctor", failed)):
        status = main.run(["control", *line.split()])
        assert (*capsys.readouterr(), status) == (output, nobody, 1), line
    assert main.run(["stop", "--robot", "--release"]) == 0
    assert capsys.readouterr() == ("", "No controller manager is running.\n")
