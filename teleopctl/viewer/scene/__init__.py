"""What stands in the picture: frames, and the robot on them."""
