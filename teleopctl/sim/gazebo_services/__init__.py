"""The services of Gazebo classic's gazebo_ros, over what simulation_interfaces does here."""
