"""The state of a simulation: services that set it, and states to go on from later."""
