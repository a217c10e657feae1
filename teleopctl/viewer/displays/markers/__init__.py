"""Displays of visualization_msgs: markers and interactive markers."""
