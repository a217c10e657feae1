"""``nav2_common``: the part that launch files use."""
