"""How long the control cycle, its controllers and its hardware take, and where it is told."""
