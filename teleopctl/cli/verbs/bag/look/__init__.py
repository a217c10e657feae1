"""Verbs that show what is in a bag."""
