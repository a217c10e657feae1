"""Joint trajectory controller, with its trajectories, tolerances, inputs and outputs."""
