"""Cameras of a simulated robot: drawn from its state, distorted, and put into messages."""
