"""``launch.launch_description_sources``."""

from .python_launch_description_source import PythonLaunchDescriptionSource

__all__ = ["PythonLaunchDescriptionSource"]
