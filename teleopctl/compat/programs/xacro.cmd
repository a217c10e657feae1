@"%TELEOPCTL_PYTHON%" -P -m teleopctl.nodes --builtin xacro xacro %*
