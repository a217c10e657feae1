"""Displays of geometry_msgs, nav_msgs and the like: poses, paths, arrows."""
