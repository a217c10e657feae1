"""MJCF files: reading, checks, and description as URDF."""
