"""xacro: expansion of descriptions, with the source line of each part."""
