@"%TELEOPCTL_PYTHON%" -P -m teleopctl test %*
