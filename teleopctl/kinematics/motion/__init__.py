"""Motion planning of a group: collision-free paths, straight lines of its tool, and timing.

Classes and functions without node or clock: positions and poses in, timed joint positions out.
"""
