"""Cameras of a simulated robot: rendered from its state, distorted, converted to messages."""
