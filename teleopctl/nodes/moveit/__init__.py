"""Executables of MoveIt: ``move_group`` and ``servo_node``."""
