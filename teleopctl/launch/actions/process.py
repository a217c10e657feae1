"""Launch actions that start a process: ``node``, ``lifecycle_node`` and ``executable``."""

from __future__ import annotations

from teleopctl.base.typed import ClassVar, Mapping, Self
from teleopctl.launch.actions.parameters import parameters
from teleopctl.launch.model import values
from teleopctl.launch.model.action import Action, Entity, Launch
from teleopctl.launch.model.descriptions import NodePart, ProcessPart
from teleopctl.launch.model.records import dataclass
from teleopctl.launch.model.template import Template, literal
from teleopctl.launch.service_calls import NodeActivation

_PROCESS_KEYS = (
    "args",
    "cwd",
    "emulate_tty",
    "env",
    "launch-prefix",
    "on_exit",
    "output",
    "required",
    "respawn",
    "respawn_delay",
    "respawn_max_retries",
    "sigkill_timeout",
    "sigterm_timeout",
)


class StartProcess(ProcessPart, Action):
    """Base of the launch actions ``node`` and ``executable``: starts a process."""

    __slots__ = ()

    def evaluate(self, launch: Launch) -> None:
        """Add the process to the launch, which starts the process after the evaluation."""
        launch.start(self)

    @classmethod
    def _parse(
        cls,
        entity: Entity,
        *,
        process_name: Template | None,
        node: NodePart | None = None,
        command: Template | None = None,
        shell: Template | None = None,
    ) -> Self:
        return cls(
            node=node,
            command=command,
            shell=shell,
            process_name=process_name,
            arguments=entity.optional("args"),
            working_directory=entity.optional("cwd"),
            environment=entity.pairs("env", "name", "value"),
            prefix=entity.optional("launch-prefix"),
            output=entity.optional("output"),
            emulate_tty=entity.optional("emulate_tty"),
            respawn=entity.optional("respawn"),
            respawn_delay=entity.optional("respawn_delay"),
            respawn_max_retries=entity.optional("respawn_max_retries"),
            shutdown_on_exit=_shutdown_on_exit(entity),
            sigterm_timeout=entity.optional("sigterm_timeout"),
            sigkill_timeout=entity.optional("sigkill_timeout"),
        )


class Node(StartProcess):
    """``node``: starts an executable of a package as a ROS node."""

    __slots__ = ()
    keys = (
        "pkg",
        "exec",
        "name",
        "namespace",
        "exec_name",
        "param",
        "remap",
        "ros_args",
        *_PROCESS_KEYS,
    )
    # Keys of ROS 2 before Foxy, of ROS 1, and of launch files in Python.
    renamed: ClassVar[Mapping[str, str]] = {
        "arguments": "args",
        "executable": "exec",
        "node_executable": "exec",
        "node_name": "name",
        "node_namespace": "namespace",
        "ns": "namespace",
        "package": "pkg",
        "parameters": "param",
        "remappings": "remap",
        "ros_arguments": "ros_args",
        "type": "exec",
    }

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``node`` entry describes."""
        node = NodePart(
            package=entity.optional("pkg"),
            executable=entity.required("exec"),
            name=entity.optional("name"),
            namespace=entity.optional("namespace"),
            parameters=tuple(parameters(entity.element("param"))),
            remaps=entity.pairs("remap", "from", "to"),
            ros_arguments=entity.optional("ros_args"),
        )
        return cls._parse(entity, process_name=entity.optional("exec_name"), node=node)


@dataclass(frozen=True, slots=True, kw_only=True)
class LifecycleNode(Action):
    """``lifecycle_node``: starts a managed node, and activates the node if ``autostart`` is set.

    Attributes:
        node: Process of the node.
        autostart: Whether to configure and activate the node once it is in the graph.
    """

    keys = (*Node.keys, "autostart")
    renamed = Node.renamed

    node: Node
    autostart: Template | None

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``lifecycle_node`` entry describes."""
        entity.required_element("name")
        return cls(node=Node.parse(entity), autostart=entity.optional("autostart"))

    def evaluate(self, launch: Launch) -> None:
        """Add the node's process, and with ``autostart`` service calls that activate the node."""
        plan = launch.start(self.node)
        assert plan.node_name is not None, "it has a name"
        with values.at_key("autostart"):
            begins = self.autostart is not None and values.boolean(launch.text(self.autostart))
        if begins:
            activation = NodeActivation(plan.node_name, launch)
            launch.register(activation)
            launch.work(activation)


class Executable(StartProcess):
    """``executable``: starts a command line that is no ROS node."""

    __slots__ = ()
    keys = ("cmd", "name", "shell", *_PROCESS_KEYS)

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that an ``executable`` entry describes."""
        return cls._parse(
            entity,
            process_name=entity.optional("name"),
            command=entity.required("cmd"),
            shell=entity.optional("shell"),
        )


def _shutdown_on_exit(entity: Entity) -> Template | None:
    on_exit = entity.element("on_exit")
    if on_exit is None:
        return entity.optional("required")
    if on_exit.value != "shutdown":
        raise on_exit.error(f"expected 'shutdown', got {on_exit.describe()}")
    return literal("true")
