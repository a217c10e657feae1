"""Beside the floors: the import names of ROS 2's Python packages.

``site/`` holds real packages (``rclpy``, ``tf2_ros``, …) and goes on the module search path as one
entry; nothing imports them by way of this package. Message packages, of which there is one for each
that has definitions, come from a finder. ``activation`` puts both in place.
"""
