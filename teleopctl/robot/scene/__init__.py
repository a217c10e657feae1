"""Scenes: objects that SDF or YAML world files describe, read into one set of records."""
