"""Readers of launch files: each turns one language into `teleopctl.launch.model`."""
