"""Floor 5: one module per executable that ``teleopctl run`` can start."""
