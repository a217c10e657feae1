"""Launch files: ROS 2's launch, and the supervisor of what it starts.

A file is read into a description (`frontends`, `model`), evaluated with its arguments into a plan
of processes (`evaluation`), and the plan is carried out (`execution`), in the foreground or,
through ``python -m teleopctl.launch``, in the background.
"""
