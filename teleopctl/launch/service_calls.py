"""Service calls that a launch makes: activate lifecycle nodes, load components."""

from __future__ import annotations

import itertools
import os
import threading
from pathlib import Path
from weakref import WeakKeyDictionary

from teleopctl.base.typed import TYPE_CHECKING, Any, Callable, Iterable, Iterator, Sequence
from teleopctl.errors import TeleopctlError
from teleopctl.launch.model.action import Launch, Step
from teleopctl.launch.model.events import ProcessExited, ShutdownBegan
from teleopctl.launch.model.plan import ComponentPlan
from teleopctl.launch.model.records import dataclass

if TYPE_CHECKING:
    from teleopctl.interfaces import ServiceType
    from teleopctl.node import Context, Node

CONFIGURE, ACTIVATE = 1, 3
"""Transition ids of ``lifecycle_msgs/msg/Transition``."""

# A service may be in the graph a moment before it can be called.
_AGAIN_AFTER_S = 0.05
_numbers = itertools.count(1)


class CallSequence:
    """Base of service calls that a launch makes one after the other, on a thread.

    The calls wait for nodes that do not exist yet. The calls stop when the launch ends, or when the
    process of the called node has ended and is not restarted.

    Args:
        node_name: Full name of the node whose services are called.
        launch: Launch that makes the calls.
    """

    wants_output: bool = False

    def __init__(self, node_name: str, launch: Launch) -> None:
        self.node_name = node_name
        self._launch = launch
        self._given_up = threading.Event()
        self._context: Context | None = None

    def describe(self) -> Iterable[str]:
        """Yield lines that describe the calls, for a dry run."""
        raise NotImplementedError

    def make_calls(self, node: Node) -> None:
        """Make the service calls from a node of the launch; called on a thread.

        Raises:
            CallsCancelledError: The launch or the process of the called node ends.
        """
        raise NotImplementedError

    def finish(self) -> None:
        """Do nothing; a subclass cleans up here after the last call or an error, on the thread."""

    def begin(self, report: Callable[[TeleopctlError | None], None]) -> None:
        """Start to make the calls on a thread; ``report`` is called when all have ended."""
        # A daemon, so that the launch can end while the thread waits for Zenoh.
        threading.Thread(
            target=self._work, args=(report,), name="service_calls", daemon=True
        ).start()

    def dry_run(self) -> None:
        """Return None: in a dry run no processes follow from the calls."""

    def answers(self, _event: object, _launch: Launch) -> bool:
        """Return False: no event leads to further steps through these calls."""
        return False

    def respond(self, event: object, launch: Launch) -> tuple[Step, ...]:
        """Handle an event: log lines of the thread, or stop when launch or called process ends."""
        if isinstance(event, _ThreadLog) and event.calls is self:
            launch.log(event.level, event.text, event.logger)
        elif isinstance(event, ShutdownBegan) or (
            isinstance(event, ProcessExited)
            and event.plan.node_name == self.node_name
            and not event.plan.respawn
        ):
            self._given_up.set()
            if self._context is not None:
                self._context.try_shutdown()
        return ()

    def log(self, level: str, text: str, logger: str) -> None:
        """Log a line in the launch's log; called on the thread."""
        self._launch.emit(_ThreadLog(self, level, text, logger))

    # Any: requests and responses of any service.
    def call(self, node: Node, kind: type[ServiceType[Any, Any]], name: str, request: Any) -> Any:
        """Wait for a service, call the service and return the response.

        Raises:
            CallsCancelledError: The launch or the process of the called node ends.
        """
        from teleopctl.node import ServiceUnavailableError

        client = node.create_client(kind, name)
        while client.wait_for_service():
            try:
                return client.call_async(request).wait_for_response()
            except ServiceUnavailableError:
                if self._given_up.wait(_AGAIN_AFTER_S):
                    break
        raise CallsCancelledError

    def activate(self, node: Node, name: str) -> None:
        """Configure and activate a lifecycle node by service calls; log an error if one is refused.

        Raises:
            CallsCancelledError: The launch or the process of the called node ends.
        """
        from teleopctl.interfaces import get_service

        kind = get_service("lifecycle_msgs/srv/ChangeState")
        for number, label in ((CONFIGURE, "CONFIGURE"), (ACTIVATE, "ACTIVATE")):
            request = kind.Request()
            request.transition.id = number
            if not self.call(node, kind, f"{name}/change_state", request).success:
                text = f"Failed to make transition 'TRANSITION_{label}' for LifecycleNode '{name}'"
                self.log("ERROR", text, "launch_ros.utilities.lifecycle_event_manager")
                return

    def _work(self, report: Callable[[TeleopctlError | None], None]) -> None:
        from teleopctl.node import Context, ExternalShutdownException, Node, SignalHandlerOptions

        context = self._context = Context()
        try:
            context.init(
                [],
                initialize_logging=False,
                session_mode="client",
                signal_handler_options=SignalHandlerOptions.NO,
            )
            if not self._given_up.is_set():
                node = Node(
                    f"_launch_ros_{os.getpid()}_{next(_numbers)}",
                    context=context,
                    enable_rosout=False,
                    start_parameter_services=False,
                )
                self.make_calls(node)
        except (CallsCancelledError, ExternalShutdownException):
            pass
        except Exception as error:  # noqa: BLE001 -- nothing else would report it
            if not self._given_up.is_set():
                self.log("ERROR", f"{self.node_name}: {error}", "launch")
        finally:
            context.try_shutdown()
            self.finish()
            report(None)


class CallsCancelledError(TeleopctlError):
    """The service calls stopped because the launch or the called process ends."""

    def __init__(self) -> None:
        super().__init__("given up")


class NodeActivation(CallSequence):
    """Service calls that configure and activate a lifecycle node."""

    def describe(self) -> Iterable[str]:
        """Yield a line with the name of the node to activate, for a dry run."""
        yield f"then {self.node_name} is configured and activated"

    def make_calls(self, node: Node) -> None:
        """Call the services that configure and activate the lifecycle node."""
        self.activate(node, self.node_name)


@dataclass(frozen=True, slots=True)
class _ThreadLog:
    """Event: a line that the thread of a call sequence logs."""

    calls: CallSequence
    level: str
    text: str
    logger: str


@dataclass(frozen=True, slots=True)
class _NameKnown:
    """Event: a component without a name in the launch file has been loaded."""

    calls: CallSequence
    name: str


_LOGGER = "launch_ros.actions.load_composable_nodes"

# By launch and container name: the event that is set when the last loads have ended.
_turns: WeakKeyDictionary[Launch, dict[str, threading.Event]] = WeakKeyDictionary()


class ComponentLoading(CallSequence):
    """Service calls that load components into a container.

    Args:
        container: Full name of the container's node.
        components: Components to load, in order.
        launch: Launch that makes the calls.

    Attributes:
        components: Components to load, in order.
    """

    def __init__(self, container: str, components: Sequence[ComponentPlan], launch: Launch) -> None:
        super().__init__(container, launch)
        self.components = tuple(components)
        # Components are loaded in the order of the launch file.
        turns = _turns.setdefault(launch, {})
        self._before = turns.get(container)
        self._is_done = turns[container] = threading.Event()

    def describe(self) -> Iterator[str]:
        """Yield each component as a command line, for a dry run."""
        for each in self.components:
            words = [each.package, each.plugin]
            if each.name:
                words += ["-r", f"__node:={each.name}"]
            if each.namespace != "/":
                words += ["-r", f"__ns:={each.namespace}"]
            for file in each.parameter_files:
                words += ["--params-file", file]
            for rule in each.remaps:
                words += ["-r", rule]
            words += [f"{name}:={value}" for name, value in each.extra_arguments]
            then = ", then configured and activated" if each.autostart else ""
            yield f"into {self.node_name}: {' '.join(words)}{then}"

    def make_calls(self, node: Node) -> None:
        """Load each component by the container's service, after earlier loads; log the results."""
        if self._before is not None:
            self._before.wait()
        from teleopctl.interfaces import get_service

        kind = get_service("composition_interfaces/srv/LoadNode")
        for each in self.components:
            request = _request(kind.Request(), each)
            response = self.call(node, kind, f"{self.node_name}/_container/load_node", request)
            if response.success:
                text = f"Loaded node '{response.full_node_name}' in container '{self.node_name}'"
                self.log("INFO", text, _LOGGER)
                if each.name is None:
                    self._launch.emit(_NameKnown(self, response.full_node_name))
                if each.autostart:
                    self.activate(node, response.full_node_name)
            else:
                self.log(
                    "ERROR",
                    f"Failed to load node '{each.name or ''}' of type '{each.plugin}' in container "
                    f"'{self.node_name}': {response.error_message}",
                    _LOGGER,
                )

    def respond(self, event: object, launch: Launch) -> tuple[Step, ...]:
        """Count a component whose name only the container knew; otherwise as the base does."""
        if isinstance(event, _NameKnown) and event.calls is self:
            launch.count_node(event.name, _LOGGER)
            return ()
        return super().respond(event, launch)

    def finish(self) -> None:
        """Let the next sequence of loads into the same container start."""
        self._is_done.set()


# Any: a LoadNode request.
def _request(request: Any, plan: ComponentPlan) -> Any:
    from teleopctl.node import Parameter, read_parameter_file

    # For a node whose name is unknown here, only sections with wildcards apply.
    full_name = f"{plan.namespace.rstrip('/')}/{plan.name or ''}"
    values: dict[str, Any] = {}
    for file in plan.parameter_files:
        read = read_parameter_file(Path(file), may_be_plain=True)
        values.update(read.for_node(full_name, names_win=True))
    request.package_name = plan.package
    request.plugin_name = plan.plugin
    request.node_name = plan.name or ""
    request.node_namespace = plan.namespace
    request.remap_rules = list(plan.remaps)
    request.parameters = [
        Parameter(name, value=value).to_parameter_msg() for name, value in values.items()
    ]
    extra: dict[str, Any] = dict(plan.extra_arguments)
    request.extra_arguments = [
        Parameter(name, value=value).to_parameter_msg() for name, value in extra.items()
    ]
    return request
