"""Floor 3: the robot description: xacro, URDF, ros2_control and Gazebo tags."""
