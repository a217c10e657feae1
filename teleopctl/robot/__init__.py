"""The robot description: xacro, URDF, ``<ros2_control>``, ``<gazebo>`` and forward kinematics."""
