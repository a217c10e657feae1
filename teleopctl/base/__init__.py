"""Ground that needs no message type, node or robot: rules that every other room may ask."""

__version__ = "0.1.0"
