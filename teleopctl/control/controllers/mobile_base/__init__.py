"""Controllers of wheeled mobile bases, with velocity commands and odometry."""
