"""Motion: paths of a group that touch nothing, straight lines of its tool, and their timing.

Classes and functions without node or clock: positions and poses in, timed joint positions out.
"""
