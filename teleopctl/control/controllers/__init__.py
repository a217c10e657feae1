"""Controllers: they compute commands from states and goals."""
