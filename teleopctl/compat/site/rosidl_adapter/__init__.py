"""``rosidl_adapter``. Definitions of messages, services and actions, as values."""
