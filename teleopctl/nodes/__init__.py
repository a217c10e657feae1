"""Floor 5: the programs that ``teleopctl run`` starts, one module with a ``main`` each."""
