"""Transforms between coordinate frames, kept over time."""
