"""Lifecycle nodes, which other programs can configure, activate and shut down.

The classes are those of ``rclpy.lifecycle``, the states and transitions those of
``lifecycle_msgs``; see design.ros2.org/articles/node_lifecycle.html.
"""
