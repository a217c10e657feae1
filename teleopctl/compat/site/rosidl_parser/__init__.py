"""``rosidl_parser``: the types of fields as Python objects."""
