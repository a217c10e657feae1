"""Compares a recorded session with what a simulator does with its commands."""
