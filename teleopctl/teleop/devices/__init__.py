"""teleopctl's own teleoperation devices; see `teleopctl.teleop.device`."""
