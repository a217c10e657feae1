"""Displays of the 3D view, under RViz's names: one file for each kind."""
