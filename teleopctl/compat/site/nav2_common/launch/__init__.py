"""``nav2_common.launch``: substitutions on parameter files."""

from .has_node_params import HasNodeParams
from .launch_config_as_bool import LaunchConfigAsBool
from .parse_multirobot_pose import ParseMultiRobotPose
from .replace_string import ReplaceString
from .rewritten_yaml import RewrittenYaml

__all__ = [
    "HasNodeParams",
    "LaunchConfigAsBool",
    "ParseMultiRobotPose",
    "ReplaceString",
    "RewrittenYaml",
]
