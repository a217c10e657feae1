"""MJCF files: read, checked, and described as URDF."""
