"""Tabs of the viewer's page beside the 3D view: one file for each."""
