"""The programs of ROS 2's tutorials, under their names, as ordinary ROS 2 sources in Python.

Those of ``demo_nodes_py``, ``action_tutorials_py`` and ``lifecycle_py``, and of ``demo_nodes_cpp``
the ones that most tutorials start; they print the same here as there.
"""
