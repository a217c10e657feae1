"""Fields of messages by their paths, such as ``position[0]``."""
