"""Models of robots that are written for MuJoCo."""
