"""What the simulator itself does for plug-ins of Gazebo."""
