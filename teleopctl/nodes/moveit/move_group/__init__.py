"""``moveit_ros_move_group/move_group``: kinematics, planning scene, planning and execution."""
