"""Executables of ROS 2's package ``topic_tools``: topics are relayed, thinned out and selected."""
