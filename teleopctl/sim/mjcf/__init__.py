"""What a simulation of a robot that is written for MuJoCo has besides."""
