"""Floor 3: transforms in time."""
