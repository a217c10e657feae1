"""Service calls that a launch makes: activate lifecycle nodes, load components."""

from __future__ import annotations

import itertools
import os
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from teleopctl.errors import TeleopctlError
from teleopctl.launch.model.action import Launch, Step
from teleopctl.launch.model.events import ProcessExited, ShutdownBegan
from teleopctl.launch.model.plan import ComponentPlan

if TYPE_CHECKING:
    from teleopctl.interfaces import ServiceType
    from teleopctl.node import Context, Node

CONFIGURE, ACTIVATE = 1, 3
"""Of ``lifecycle_msgs/msg/Transition``."""

# A service may stand in the graph a moment before it can be reached.
_AGAIN_AFTER_S = 0.05
_numbers = itertools.count(1)


class CallSequence:
    """Calls services of nodes one after the other, beside the launch's processes.

    It waits for nodes that are not there yet. It is given up when the launch ends, or when the
    process that it asks has ended for good.

    Args:
        node_name: Full name of the node that is asked.
        launch: The launch.
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

    def ask(self, node: Node) -> None:
        """Make the calls, on a thread of their own; `node` is the launch's node.

        Raises:
            GivenUpError: What `call` raises.
        """
        raise NotImplementedError

    def ended(self) -> None:
        """Handle the end of the last call."""

    def begin(self, report: Callable[[TeleopctlError | None], None]) -> None:
        """Start calling on a thread; report the end to the event loop."""
        # The launch does not wait for a thread that may wait for Zenoh.
        threading.Thread(target=self._work, args=(report,), name="asking", daemon=True).start()

    def foreseen(self) -> None:
        """Return None: no processes follow from the calls."""

    def answers(self, _event: object, _launch: Launch) -> bool:
        """Return False: no other handler's events are answered."""
        return False

    def respond(self, event: object, launch: Launch) -> tuple[Step, ...]:
        """Stop calling when the launch or the called process ends, and log the thread's lines."""
        if isinstance(event, _Said) and event.asking is self:
            launch.say(event.level, event.text, event.logger)
        elif isinstance(event, ShutdownBegan) or (
            isinstance(event, ProcessExited)
            and event.plan.node_name == self.node_name
            and not event.plan.respawn
        ):
            self._given_up.set()
            if self._context is not None:
                self._context.try_shutdown()
        return ()

    def say(self, level: str, text: str, logger: str) -> None:
        """Log a line of the launch."""
        self._launch.emit(_Said(self, level, text, logger))

    # Any: requests and responses of any service.
    def call(self, node: Node, kind: type[ServiceType[Any, Any]], name: str, request: Any) -> Any:
        """Call a service, waiting until it is there, and return the response.

        Raises:
            GivenUpError: There will be none.
        """
        from teleopctl.node import ServiceUnavailableError

        client = node.create_client(kind, name)
        while client.wait_for_service():
            try:
                return client.call_async(request).wait_for_response()
            except ServiceUnavailableError:
                if self._given_up.wait(_AGAIN_AFTER_S):
                    break
        raise GivenUpError

    def activate(self, node: Node, name: str) -> None:
        """Configure and activate a lifecycle node.

        Raises:
            GivenUpError: What `call` raises.
        """
        from teleopctl.interfaces import get_service

        kind = get_service("lifecycle_msgs/srv/ChangeState")
        for number, label in ((CONFIGURE, "CONFIGURE"), (ACTIVATE, "ACTIVATE")):
            request = kind.Request()
            request.transition.id = number
            if not self.call(node, kind, f"{name}/change_state", request).success:
                text = f"Failed to make transition 'TRANSITION_{label}' for LifecycleNode '{name}'"
                self.say("ERROR", text, "launch_ros.utilities.lifecycle_event_manager")
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
                self.ask(node)
        except (GivenUpError, ExternalShutdownException):
            pass
        except Exception as error:  # noqa: BLE001 -- nobody else would be told
            if not self._given_up.is_set():
                self.say("ERROR", f"{self.node_name}: {error}", "launch")
        finally:
            context.try_shutdown()
            self.ended()
            report(None)


class GivenUpError(TeleopctlError):
    """The called node has ended for good."""

    def __init__(self) -> None:
        super().__init__("given up")


class Activation(CallSequence):
    """Configures and activates a lifecycle node."""

    def describe(self) -> Iterable[str]:
        """Yield lines that describe the calls, for a dry run."""
        yield f"then {self.node_name} is configured and activated"

    def ask(self, node: Node) -> None:
        """Call the services that configure and activate the node."""
        self.activate(node, self.node_name)


@dataclass(frozen=True, slots=True)
class _Said:
    """What the thread has to tell the person in front of the terminal."""

    asking: CallSequence
    level: str
    text: str
    logger: str


_LOGGER = "launch_ros.actions.load_composable_nodes"

# The last one that loads into a container of a launch, by the container's name.
_turns: WeakKeyDictionary[Launch, dict[str, threading.Event]] = WeakKeyDictionary()


class Loading(CallSequence):
    """Loads components into a container, once that is there.

    Args:
        container: Full name of its node.
        components: The components, in order.
        launch: The launch.

    Attributes:
        components: The components.
    """

    def __init__(self, container: str, components: Sequence[ComponentPlan], launch: Launch) -> None:
        super().__init__(container, launch)
        self.components = tuple(components)
        # What a file says first is loaded first.
        turns = _turns.setdefault(launch, {})
        self._before = turns.get(container)
        self._is_done = turns[container] = threading.Event()

    def describe(self) -> Iterator[str]:
        """Yield the components as command lines, for a dry run."""
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

    def ask(self, node: Node) -> None:
        """Load the components, after earlier loads of the container have ended."""
        if self._before is not None:
            self._before.wait()
        from teleopctl.interfaces import get_service

        kind = get_service("composition_interfaces/srv/LoadNode")
        for each in self.components:
            request = _request(kind.Request(), each)
            response = self.call(node, kind, f"{self.node_name}/_container/load_node", request)
            if response.success:
                text = f"Loaded node '{response.full_node_name}' in container '{self.node_name}'"
                self.say("INFO", text, _LOGGER)
                if each.autostart:
                    self.activate(node, response.full_node_name)
            else:
                self.say(
                    "ERROR",
                    f"Failed to load node '{each.name or ''}' of type '{each.plugin}' in container "
                    f"'{self.node_name}': {response.error_message}",
                    _LOGGER,
                )

    def ended(self) -> None:
        """Let the next load request of the container start."""
        self._is_done.set()


# Any: a LoadNode request.
def _request(request: Any, plan: ComponentPlan) -> Any:
    from teleopctl.node import Parameter, read_parameter_file

    # Sections with wildcards count for a node whose name is not known here.
    full_name = f"{plan.namespace.rstrip('/')}/{plan.name or ''}"
    values: dict[str, Any] = {}
    for file in plan.parameter_files:
        values.update(read_parameter_file(Path(file)).for_node(full_name))
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
