"""``ros_gz_bridge``: the part that launch files use."""
