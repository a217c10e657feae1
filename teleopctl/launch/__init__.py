"""Launch files: ROS 2's YAML launch front end, and the supervisor of what it starts.

A file is read into descriptions (`parser`, `descriptions`), evaluated with its arguments into a
plan of processes (`evaluation`, `context`, `template`, `substitutions`, `expression`), and the plan
is carried out by `supervisor`, in the foreground or, through ``python -m teleopctl.launch``,
in the background.
"""
