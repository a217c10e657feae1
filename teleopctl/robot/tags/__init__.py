"""Tables of the tags and attributes in robot descriptions, and their treatment."""
