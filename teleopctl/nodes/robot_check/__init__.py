"""What becomes of a robot's file: how it is read, what was repaired, and whether it stands."""
