"""Ground that needs no message type, node or robot: rules that every other room may ask."""
