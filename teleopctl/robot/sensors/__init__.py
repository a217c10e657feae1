"""What a robot description says of sensors: their tags, and the names of their topics."""
