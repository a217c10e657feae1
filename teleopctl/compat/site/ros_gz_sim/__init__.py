"""``ros_gz_sim``: the part that launch files use."""
