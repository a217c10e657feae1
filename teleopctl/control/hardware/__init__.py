"""Hardware components: what reads states from a robot and writes commands to it."""
