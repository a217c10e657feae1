"""Displays of visualization_msgs: markers, and those that can be moved by hand."""
