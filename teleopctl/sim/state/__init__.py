"""State of a simulation: services that set it, and saved states to continue from."""
