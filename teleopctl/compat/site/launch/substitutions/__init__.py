"""``launch.substitutions``."""

from .launch_configuration import LaunchConfiguration
from .substitution_failure import SubstitutionFailure
from .text_substitution import TextSubstitution
from .this_launch_file_dir import ThisLaunchFileDir

__all__ = ["LaunchConfiguration", "SubstitutionFailure", "TextSubstitution", "ThisLaunchFileDir"]
