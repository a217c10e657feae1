"""The files that robots are written in: which kind one is, and each kind as URDF."""
