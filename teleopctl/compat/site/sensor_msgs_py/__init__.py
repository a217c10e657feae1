"""``sensor_msgs_py``: point clouds in numpy."""
