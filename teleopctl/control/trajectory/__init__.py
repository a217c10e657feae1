"""Trajectories of joints: points, interpolation, validation. Pure arithmetic, no ROS."""
