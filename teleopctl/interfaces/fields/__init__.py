"""Fields of messages: by their paths, such as ``position[0]``, and what they cannot take."""
