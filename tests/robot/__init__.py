"""Tests of floor 3: the robot description."""
