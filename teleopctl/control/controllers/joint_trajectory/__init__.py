"""``joint_trajectory_controller/JointTrajectoryController`` and the parts that only it uses."""
