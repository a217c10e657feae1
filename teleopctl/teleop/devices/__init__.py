"""teleopctl's own teleop devices, by which a hand steers a robot; see `teleopctl.teleop.device`."""
