"""``controller_manager``: the part that launch files use."""
