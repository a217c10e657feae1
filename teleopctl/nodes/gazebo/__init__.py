"""Gazebo's programs of ``ros_gz_sim`` and ``gazebo_ros``, with MuJoCo as the simulator."""
