"""``moveit_servo/servo_node``: a stream of commands becomes safe commands of a controller."""
