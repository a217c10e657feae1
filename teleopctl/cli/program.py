"""The program's name, and the variable by which a shell's completion script calls it."""

PROGRAM = "teleopctl"
COMPLETION_VARIABLE = "_TELEOPCTL_COMPLETE"
"""Set by the script when it wants the candidates for a word."""
