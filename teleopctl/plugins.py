"""The one registry of what a stranger may add: controllers, sensors, verbs and so on, by name.

A kind of plug-in has an entry-point group and a table of ours. An installed distribution adds one
with an entry in its ``pyproject.toml``:

    [project.entry-points."teleopctl.controllers"]
    "my_controllers/Gripper" = "my_controllers.gripper:Gripper"

Entry points are read from the metadata of every installed distribution, which takes tens of
milliseconds. So ours stand in the tables below, and the entry points are read only when a name is
in none of them, and where all names are listed. Ours win over a stranger's of the same name.

A plug-in is imported when it is used and never before: a broken one breaks nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from teleopctl.errors import BrokenPluginError, UnknownPluginError, did_you_mean

if TYPE_CHECKING:
    from importlib.metadata import Distribution


# Every command loads this module, and making a named tuple takes half a millisecond.
class Kind:
    """A kind of plug-in.

    Attributes:
        noun: What one is called in messages.
        group: The entry-point group of strangers' plug-ins.
        ours: Those that come with teleopctl, as ``module:object`` by name.
        bases: What a plug-in has to be, as ``module:Class``; empty for anything.
        classes: Whether plug-ins are classes derived from ``bases``, rather than objects of them.
        direct: Whether ``module:object`` may stand where a name is expected.
        summaries: One line on each of ours, where a list shows it without importing anything.
    """

    __slots__ = ("bases", "classes", "direct", "group", "noun", "ours", "summaries")

    def __init__(
        self,
        noun: str,
        group: str,
        ours: dict[str, str],
        *,
        bases: tuple[str, ...] = (),
        classes: bool = True,
        direct: bool = False,
        summaries: Mapping[str, str] | None = None,
    ) -> None:
        self.noun = noun
        self.group = group
        self.ours = ours
        self.bases = bases
        self.classes = classes
        self.direct = direct
        self.summaries = summaries or {}


class Plugin:
    """A plug-in that has not been imported.

    Attributes:
        name: What it is asked for by.
        target: ``module:object``.
        distribution: The distribution that brings it; empty for ours.
    """

    __slots__ = ("distribution", "name", "target")

    def __init__(self, name: str, target: str, distribution: str = "") -> None:
        self.name = name
        self.target = target
        self.distribution = distribution


def find(kind: Kind, name: str) -> Plugin | None:
    """Look a plug-in up by its name or, where the kind allows that, as ``module:object``."""
    if name in kind.ours:
        return Plugin(name, kind.ours[name])
    if (stranger := _strangers(kind.group).get(name)) is not None:
        return stranger
    if kind.direct and ":" in name and "/" not in name:
        return Plugin(name, name)
    return None


def available(kind: Kind) -> dict[str, Plugin]:
    """Every plug-in of a kind: ours in the order of their table, then strangers' sorted."""
    plugins = {name: Plugin(name, target) for name, target in kind.ours.items()}
    for name, stranger in _strangers(kind.group).items():
        plugins.setdefault(name, stranger)
    return plugins


def load(kind: Kind, name: str) -> Any:
    """Import a plug-in.

    Returns:
        The class or object; what it is depends on the kind, so the caller names the type.

    Raises:
        UnknownPluginError: None has that name; the message lists those that there are.
        BrokenPluginError: It cannot be imported, or is not what its kind has to be.
    """
    plugin = find(kind, name)
    if plugin is None:
        names = sorted(available(kind))
        listed = "\n".join(f"  {known}" for known in names)
        raise UnknownPluginError(
            f"There is no {kind.noun} '{name}'. Available are:\n{listed}",
            hint=did_you_mean(name, names),
        )
    if name in kind.ours:
        return _imported(plugin.target)
    whose = f" of {plugin.distribution}" if plugin.distribution else ""
    what = f"{kind.noun} '{name}'{whose}"
    try:
        found = _imported(plugin.target)
    except (Exception, SystemExit) as error:
        raise BrokenPluginError(
            f"{what}: {plugin.target} cannot be imported: {type(error).__name__}: {error}"
        ) from error
    if kind.bases and not _is_one(found, kind):
        relation = "a subclass" if kind.classes else "an object"
        raise BrokenPluginError(
            f"{what}: {plugin.target} is not {relation} of {' or '.join(kind.bases)}"
        )
    return found


def _imported(target: str) -> Any:
    module, _, attribute = target.partition(":")
    return getattr(import_module(module), attribute)


def _is_one(found: object, kind: Kind) -> bool:
    bases = tuple(_imported(base) for base in kind.bases)
    if kind.classes:
        return isinstance(found, type) and issubclass(found, bases)
    return isinstance(found, bases)


def _strangers(group: str) -> dict[str, Plugin]:
    return _installed().get(group, {})


@cache
def _installed() -> dict[str, dict[str, Plugin]]:
    """The plug-ins of all installed distributions, by group and name, sorted.

    A distribution whose entries cannot be read is reported and passed over, as is the second one
    to offer a name.
    """
    from importlib.metadata import distributions

    owners: dict[str, list[tuple[str, str, str]]] = {}
    for distribution in distributions():
        try:
            if "[teleopctl." not in (distribution.read_text("entry_points.txt") or ""):
                continue
            owner = distribution.name
            entries = [
                (entry.group, entry.name, entry.value) for entry in distribution.entry_points
            ]
        except Exception as error:  # noqa: BLE001 -- whatever is wrong with it, the others work
            _warn(f"The plug-ins of {_name_of(distribution)} cannot be read: {error}")
            continue
        # The first one on the path is the one whose modules are imported.
        owners.setdefault(owner, entries)
    found: dict[str, dict[str, Plugin]] = {}
    for owner, entries in sorted(owners.items()):
        for group, name, value in entries:
            # What stands in brackets are extras, an obsolete part of entry points.
            plugin = Plugin(name, value.partition("[")[0].strip(), owner)
            known = found.setdefault(group, {}).setdefault(name, plugin)
            if known.distribution != owner and group.startswith("teleopctl."):
                _warn(
                    f"Both {known.distribution} and {owner} offer '{name}' in {group}: "
                    f"that of {known.distribution} is used"
                )
    return {group: dict(sorted(plugins.items())) for group, plugins in found.items()}


def _name_of(distribution: Distribution) -> str:
    try:
        return distribution.name
    except Exception:  # noqa: BLE001 -- its metadata may be what is wrong
        return "a distribution without a name"


def _warn(text: str) -> None:
    from logging import getLogger

    getLogger(__name__).warning(text)


_VERBS = {
    "run": ("run:VERB", "Start one node."),
    "python": ("python:VERB", "Start Python with rclpy to import."),
    "launch": ("launch:VERB", "Start many nodes from a launch file."),
    "ps": ("ps:VERB", "List what runs in the background."),
    "logs": ("logs:VERB", "Show the output of a background process."),
    "stop": ("stop:VERB", "Stop background processes."),
    "topic": ("topic:GROUP", "List, watch, measure and publish topics."),
    "node": ("node:GROUP", "List nodes and what they offer."),
    "param": ("param:GROUP", "Read and change parameters of nodes."),
    "service": ("service:GROUP", "List and call services."),
    "pkg": ("pkg:GROUP", "Find packages."),
    "control": ("control:GROUP", "Manage controllers and hardware."),
    "camera": ("camera:GROUP", "Save pictures of cameras."),
    "tf": ("tf:GROUP", "Watch transforms between frames."),
    "interface": ("interface:GROUP", "Use definitions of messages, services and actions."),
    "daemon": ("daemon:GROUP", "Manage the router that introduces nodes to each other."),
    "completion": ("completion:GROUP", "Print the completion script of a shell."),
}

VERBS = Kind(
    "verb",
    "teleopctl.verbs",
    {name: f"teleopctl.cli.verbs.{target}" for name, (target, _) in _VERBS.items()},
    bases=("teleopctl.cli.verb:Verb", "teleopctl.cli.verb:Group"),
    classes=False,
    summaries={name: summary for name, (_, summary) in _VERBS.items()},
)
"""The words behind ``teleopctl``."""

_CANDIDATES = "teleopctl.cli.candidates"

COMPLETIONS = Kind(
    "completion",
    "teleopctl.completions",
    {
        "controllers": "teleopctl.cli.verbs.control.candidates:controllers",
        "frames": "teleopctl.cli.verbs.tf.candidates:frames",
        "launch_words": f"{_CANDIDATES}:launch_words",
        "logged_processes": f"{_CANDIDATES}:logged_processes",
        "message_types": f"{_CANDIDATES}:message_types",
        "nodes": f"{_CANDIDATES}:nodes",
        "packages": f"{_CANDIDATES}:package_names",
        "parameter_names": "teleopctl.cli.verbs.param.candidates:parameter_names",
        "programs": f"{_CANDIDATES}:programs",
        "running_processes": f"{_CANDIDATES}:running_processes",
        "services": f"{_CANDIDATES}:services",
        "topics": f"{_CANDIDATES}:topics",
    },
    direct=True,
)
"""What Tab offers: functions from the beginning of a word to the whole words that fit."""

NODES = Kind(
    "node",
    "teleopctl.nodes",
    {
        name: f"teleopctl.nodes.{module}:main"
        for name, module in {
            "camera/camera": "camera",
            "controller_manager/ros2_control_node": "controller_manager",
            "controller_manager/spawner": "spawner",
            "controller_manager/unspawner": "unspawner",
            "joint_state_publisher/joint_state_publisher": "joint_state_publisher",
            "mujoco_sim/mujoco_sim": "mujoco_sim",
            "robot_state_publisher/robot_state_publisher": "robot_state_publisher",
            "teleop_py_pkg/simple_parameter": "simple_parameter",
            "teleop_py_pkg/simple_publisher": "simple_publisher",
            "teleop_py_pkg/simple_subscriber": "simple_subscriber",
            "teleop_robot_py_pkg/simple_parameter": "simple_parameter",
            "teleop_robot_py_pkg/simple_publisher": "simple_publisher",
            "teleop_robot_py_pkg/simple_subscriber": "simple_subscriber",
            "tf2_ros/static_transform_publisher": "static_transform_publisher",
            "tf2_ros/tf2_echo": "tf2_echo",
        }.items()
    }
    | {"xacro/xacro": "xacro:main"},  # the library's own program
)
"""Programs of packages, as ``package/executable``: functions that take no argument."""

_CONTROLLERS = "teleopctl.control.controllers"
_FORWARD = f"{_CONTROLLERS}.forward_command_controller"

CONTROLLERS = Kind(
    "controller",
    "teleopctl.controllers",
    {
        "joint_state_broadcaster/JointStateBroadcaster": (
            f"{_CONTROLLERS}.joint_state_broadcaster:JointStateBroadcaster"
        ),
        "joint_trajectory_controller/JointTrajectoryController": (
            f"{_CONTROLLERS}.joint_trajectory.controller:JointTrajectoryController"
        ),
        "forward_command_controller/ForwardCommandController": (
            f"{_FORWARD}:ForwardCommandController"
        ),
        "forward_command_controller/MultiInterfaceForwardCommandController": (
            f"{_FORWARD}:MultiInterfaceForwardCommandController"
        ),
        "position_controllers/JointGroupPositionController": (
            f"{_FORWARD}:JointGroupPositionController"
        ),
        "velocity_controllers/JointGroupVelocityController": (
            f"{_FORWARD}:JointGroupVelocityController"
        ),
        "effort_controllers/JointGroupEffortController": f"{_FORWARD}:JointGroupEffortController",
    },
    bases=(f"{_CONTROLLERS}.base:ControllerInterface",),
    direct=True,
)
"""Controllers, by the names that parameter files use as ``type``."""

_TOPIC = "teleopctl.control.hardware.topic:JointStateTopicSystem"

HARDWARE = Kind(
    "hardware plug-in",
    "teleopctl.hardware",
    {
        "mock_components/GenericSystem": "teleopctl.control.hardware.mock:GenericSystem",
        "gazebo_ros2_control/GazeboSystem": _TOPIC,
        "gz_ros2_control/GazeboSimSystem": _TOPIC,
        "ign_ros2_control/IgnitionSystem": _TOPIC,
        "mujoco_ros2_control/MujocoSystemInterface": _TOPIC,
        "topic_based_ros2_control/TopicBasedSystem": _TOPIC,
        "topic_based_hardware_interfaces/TopicBasedSystem": _TOPIC,
        "joint_state_topic_hardware_interface/JointStateTopicSystem": _TOPIC,
    },
    bases=("teleopctl.control.hardware.base:HardwareComponentInterface",),
    direct=True,
)
"""Hardware components, by the names that URDFs use as ``<plugin>``."""

PACKAGES = Kind("package", "teleopctl.packages", {})
"""ROS packages of files (``msg/``, ``srv/``, ``action/``, ``launch/``, ``urdf/`` and so on): the
module in whose folder they lie. It is not imported; ours are folders, see `teleopctl.packages`."""

_ACTIONS = "teleopctl.launch.actions"

LAUNCH_ACTIONS = Kind(
    "launch action",
    "teleopctl.launch_actions",
    {
        "append_env": f"{_ACTIONS}.settings:AppendEnvironment",
        "arg": f"{_ACTIONS}.settings:DeclareArgument",
        "executable": f"{_ACTIONS}.process:Executable",
        "group": f"{_ACTIONS}.nesting:Group",
        "include": f"{_ACTIONS}.nesting:Include",
        "let": f"{_ACTIONS}.settings:Let",
        "log": f"{_ACTIONS}.messages:Log",
        "node": f"{_ACTIONS}.process:Node",
        "push_ros_namespace": f"{_ACTIONS}.settings:PushNamespace",
        "set_env": f"{_ACTIONS}.settings:SetEnvironment",
        "set_parameter": f"{_ACTIONS}.settings:SetParameter",
        "set_remap": f"{_ACTIONS}.settings:SetRemap",
        "shutdown": f"{_ACTIONS}.messages:Shutdown",
        "timer": f"{_ACTIONS}.nesting:Timer",
        "unset_env": f"{_ACTIONS}.settings:UnsetEnvironment",
    },
    bases=("teleopctl.launch.model.action:Action",),
)
"""Entries of launch files, by the names that stand there (with underscores)."""

_SUBSTITUTIONS = (
    "all and anon any command dirname env equals eval file-controllers file-param filename "
    "find-exec find-pkg-share first-file if launch_log_dir log_dir node-exists not not-equals "
    "optenv or var xacro"
)

LAUNCH_SUBSTITUTIONS = Kind(
    "substitution",
    "teleopctl.launch_substitutions",
    {
        name: f"teleopctl.launch.evaluation.substitutions:{name.upper().replace('-', '_')}"
        for name in _SUBSTITUTIONS.split()
    },
    bases=("teleopctl.launch.evaluation.substitution:Substitution",),
    classes=False,
)
"""What may stand behind ``$(`` in a launch file."""

SENSORS = Kind(
    "sensor type",
    "teleopctl.sensors",
    {"imu": "teleopctl.sim.sensors.imu:Imu"},
    bases=("teleopctl.sim.sensors.base:Sensor",),
)
"""Simulated sensors, by the names that ``<sensor type="…">`` has."""
