"""Scenes: things as SDF and our own YAML describe them, read into one set of records."""
