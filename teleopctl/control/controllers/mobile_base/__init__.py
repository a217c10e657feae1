"""Controllers of wheeled bases: velocities in, wheels out, odometry back."""
