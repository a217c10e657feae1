"""What a simulator and a controller manager agree on: the two topics of lockstep."""

STATES_TOPIC = "/robot_joint_states"
COMMANDS_TOPIC = "/robot_joint_commands"

RESET_FRAME = "reset"
"""The ``frame_id`` of a state before which the robot was put elsewhere; others have none.

It stands in the state itself, so that it cannot come too early or too late.
"""
