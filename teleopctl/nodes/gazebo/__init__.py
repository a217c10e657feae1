"""Gazebo's programs, with MuJoCo behind them: those of ``ros_gz_sim`` and ``gazebo_ros``."""
