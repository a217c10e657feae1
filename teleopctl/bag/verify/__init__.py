"""Comparison of a recorded simulation run with its replay."""
