"""Tests of floor 3: transforms over time."""
