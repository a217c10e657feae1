"""Surroundings of a robot: ground, light, the world of a file, and spawned objects."""
