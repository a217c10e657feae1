"""What the verbs of ``control`` print, character for character as ros2 does, in one session.

The texts are those of the format strings of ros2controlcli and the controller manager (Jazzy). What
the manager says of a refusal stands below the verb's words; in ROS 2 it is in the manager's log.
"""

import pytest

from teleopctl.cli import main
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
        "set_controller_state nope active",
        "",
        refused("controller nope does not seem to be loaded"),
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
            "exists"
        ),
        1,
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


@pytest.mark.usefixtures("manager")
def test_they_follow_one_another_as_in_a_terminal(capsys):
    for line, output, errors, status in TEXTS:
        capsys.readouterr()
        found = main.run(["control", *line.split()])
        assert (*capsys.readouterr(), found) == (output, errors, status), line
