"""xacro: expansion of descriptions, with the line that each part was written in."""
