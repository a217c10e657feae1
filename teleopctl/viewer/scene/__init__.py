"""Contents of the 3D view as viser scene nodes: tf frames, drawings, meshes and textures."""
