"""``rosidl_adapter``. Parsed definitions of messages, services and actions."""
