"""SDF files: worlds and models read into a scene, and robots converted to URDF."""
