@"%TELEOPCTL_PYTHON%" -P -m teleopctl %*
