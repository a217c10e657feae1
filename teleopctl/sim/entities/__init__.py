"""Entities of a simulation by name, and the standard services that read and change them."""
