"""Programs by which a hand moves a robot."""
