"""Runs a recorded launch once more and compares: where `bag`, `sim` and `control` meet."""
