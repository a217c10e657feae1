"""Sensors of a robot description, measured by the simulator: one file for each type."""
