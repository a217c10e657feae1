"""Mesh files: units, textures, and meshes that are written."""
