"""Functions and classes of the library that are not defined elsewhere; see `teleopctl`."""
