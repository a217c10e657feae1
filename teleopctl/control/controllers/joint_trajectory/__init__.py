"""``joint_trajectory_controller/JointTrajectoryController`` and what it alone is made of."""
