"""Chained controllers as real processes: a PID controller, and one that commands it and goes."""

import json

import pytest

from teleopctl.interfaces import get_message

JointState = get_message("sensor_msgs/msg/JointState")
PidState = get_message("control_msgs/msg/MultiDOFStateStamped")

# Mock hardware is where it is told to be: integral action alone brings it to the reference.
CONTROLLERS = """
controller_manager:
  ros__parameters:
    update_rate: 50
    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}
    forward: {type: forward_command_controller/ForwardCommandController}
    pid: {type: pid_controller/PidController}
forward:
  ros__parameters: {joints: [pid/joint_1], interface_name: position}
pid:
  ros__parameters:
    dof_names: [joint_1]
    command_interface: position
    reference_and_state_interfaces: [position]
    gains: {joint_1: {i: 10.0, antiwindup_strategy: none}}
"""


def near(wanted):
    return lambda m: abs(dict(zip(m.name, m.position, strict=True))["joint_1"] - wanted) < 1e-2


def listed(ros):
    controllers = json.loads(ros.run("control list_controllers --json").stdout)
    return {one["name"]: (one["state"], one["is_chained"]) for one in controllers}


@pytest.fixture
def file(ros):
    path = ros.folder / "controllers.yaml"
    path.write_text(CONTROLLERS)
    return path


@pytest.mark.nightly
def test_the_lists_tell_the_chain_in_the_order_of_updates(ros, file):
    ros.launch("controller.yaml", "hardware:=mock", f"controllers_file:={file}")
    assert listed(ros) == {
        "joint_state_broadcaster": ("active", False),
        "forward": ("active", False),
        "pid": ("active", True),
    }
    lines = ros.run("control list_controllers --claimed-interfaces --chained-interfaces").stdout
    forward = lines[lines.index("forward ") : lines.index("pid ", lines.index("forward "))]
    assert [line.rstrip() for line in forward.splitlines()][1:] == [
        "\tclaimed interfaces:",
        "\t\tpid/joint_1/position",
        "\tchained to interfaces:",
        "\t\tjoint_1/position",
    ]
    interfaces = ros.run("control list_hardware_interfaces").stdout.splitlines()
    assert "\tpid/joint_1/position [available] [claimed]" in interfaces
    assert "\tpid/joint_1/position" in interfaces
    refused = ros.run("control switch_controllers --deactivate pid --strict")
    assert refused.returncode == 1
    assert (
        "Unable to deactivate controller with name 'pid' because preceding controller with name "
        "'forward' is currently active and will not be deactivated."
    ) in refused.stderr


@pytest.mark.nightly
def test_who_commands_may_come_and_go(ros, file):
    ros.launch(
        "controller.yaml",
        "hardware:=mock",
        f"controllers_file:={file}",
        "controllers:=joint_state_broadcaster pid",
    )
    message = "{dof_names: [joint_1], values: [0.5]}"
    publish = "topic pub --times 3 --rate 10 /pid/reference control_msgs/msg/MultiDOFCommand"
    assert ros.run([*publish.split(), message]).returncode == 0
    ros.wait_for_message(JointState, "/joint_states", near(0.5))
    state = ros.wait_for_message(PidState, "/pid/controller_state", lambda m: True)
    assert state.dof_states[0].name == "joint_1"
    assert state.dof_states[0].reference == 0.5
    spawner = ros.spawn_module(
        "teleopctl.nodes", f"controller_manager spawner forward -u --param-file {file}"
    )
    spawner.wait_for_line("Waiting until interrupt to unload controllers")
    assert listed(ros)["pid"] == ("active", True)
    floats = "topic pub --times 3 --rate 10 /forward/commands std_msgs/msg/Float64MultiArray"
    assert ros.run([*floats.split(), "{data: [-0.25]}"]).returncode == 0
    ros.wait_for_message(JointState, "/joint_states", near(-0.25))
    spawner.interrupt()
    spawner.wait_for_line("Successfully unloaded controllers")
    assert listed(ros) == {
        "joint_state_broadcaster": ("active", False),
        "pid": ("active", False),
    }
    assert ros.run([*publish.split(), message]).returncode == 0
    ros.wait_for_message(JointState, "/joint_states", near(0.5))
