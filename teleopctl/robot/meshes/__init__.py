"""Mesh files: the one reader, the files that they name, and meshes that are written."""
