"""Displays of MoveIt's RViz plug-ins: robot states, trajectories and the planning scene."""
