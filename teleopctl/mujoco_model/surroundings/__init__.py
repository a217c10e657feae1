"""What stands and lies around a robot: ground, light, the world of a file, and what comes later."""
