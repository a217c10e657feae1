"""The classes and functions that ``import teleopctl`` offers to programs; see `teleopctl`."""
