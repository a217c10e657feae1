"""Hardware components, which read states from a robot and write commands to it."""
