"""Programs of ROS 2's packages ``tf2_ros`` and ``tf2_tools``."""
