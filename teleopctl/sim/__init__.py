"""Floor 4: MuJoCo models built from the robot description, stepped in lockstep."""
