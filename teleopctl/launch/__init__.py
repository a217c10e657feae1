"""Floor 4: YAML launch files and the supervision of what they start."""
