"""Programs for teleoperation of robots."""
