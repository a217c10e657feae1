"""Events and requests of a lifecycle node in a launch."""

from __future__ import annotations

from queue import SimpleQueue
from threading import Event as Flag, Thread
from typing import TYPE_CHECKING, Protocol

from launch.launch_context import LaunchContext
from lifecycle_msgs.msg import TransitionEvent
from lifecycle_msgs.srv import ChangeState as ChangeStateService

from teleopctl.launch import Launch, ProcessPlan, ProcessStarted, ShutdownBegan, Step, dataclass

from .events.lifecycle import ChangeState, StateTransition
from .ros_adapters import shared_adapter

if TYPE_CHECKING:
    from rclpy.client import Client

    _Client = Client[ChangeStateService.Request, ChangeStateService.Response]

_LOOK_AT_THE_END_EVERY_S = 1.0


class NamedNode(Protocol):
    """Protocol of actions that start a node."""

    @property
    def node_name(self) -> str:
        """The node's full name."""
        ...


class LifecycleLink:
    """Event handler that emits a lifecycle node's transitions and requests transitions from it.

    A thread requests the transitions one after the other.

    Args:
        entity: The node.
        plan: Its process, at whose start it subscribes to the node; None if `begin` is called.
        launch: The launch.
    """

    wants_output: bool = False

    def __init__(self, entity: NamedNode, plan: ProcessPlan | None, launch: Launch) -> None:
        self._entity = entity
        self._process = None if plan is None else plan.name
        self._launch = launch
        self._listens = False
        self._name = entity.node_name
        self._shared = shared_adapter(LaunchContext.with_launch(launch))
        self._ending = Flag()
        self._requests: SimpleQueue[int | None] = SimpleQueue()

    def dry_run(self) -> None:
        """Return None: the node's transitions are not known before the launch."""

    def answers(self, event: object, _launch: Launch) -> bool:
        """Return whether the handler matches an event."""
        return isinstance(event, ChangeState) and event.lifecycle_node_matcher(self._entity)

    def respond(self, event: object, launch: Launch) -> tuple[Step, ...]:
        """Subscribe to the node when its process starts; queue a requested transition."""
        if isinstance(event, ProcessStarted) and event.plan.name == self._process:
            self.begin()
        elif isinstance(event, ShutdownBegan):
            self._ending.set()
            self._requests.put(None)
        elif isinstance(event, _Failed) and event.link is self:
            launch.log("ERROR", event.text, "launch_ros")
        elif self.answers(event, launch):
            assert isinstance(event, ChangeState)
            self._requests.put(event.transition_id)
        return ()

    def begin(self) -> None:
        """Start the thread that subscribes to the node and requests transitions. Idempotent."""
        if not self._listens:
            self._listens = True
            # The launch does not wait for the thread, which may wait for the node.
            Thread(target=self._work, name="launch_ros_lifecycle", daemon=True).start()

    def _work(self) -> None:
        try:
            client = self._connected()
            while (transition := self._requests.get()) is not None:
                if not self._makes(transition, client):
                    name = ChangeState.valid_transitions[transition]
                    text = f"Failed to make transition '{name}' for LifecycleNode '{self._name}'"
                    self._launch.emit(_Failed(self, text))
        except Exception as error:  # noqa: BLE001 -- reported by the launch
            if not self._ending.is_set():
                self._launch.emit(_Failed(self, f"LifecycleNode '{self._name}': {error}"))

    def _connected(self) -> _Client:
        node = self._shared.adapter().ros_node
        assert node is not None
        node.create_subscription(
            TransitionEvent,
            f"{self._name}/transition_event",
            self._emit_transition,
            10,
        )
        return node.create_client(ChangeStateService, f"{self._name}/change_state")

    def _emit_transition(self, message: TransitionEvent) -> None:
        self._launch.emit(StateTransition(action=self._entity, msg=message))

    def _makes(self, transition: int, client: _Client) -> bool:
        """Request a transition; return whether it succeeded, or True if the launch ends."""
        while not client.wait_for_service(timeout_sec=_LOOK_AT_THE_END_EVERY_S):
            if self._ending.is_set():
                return True
        request = ChangeStateService.Request()
        request.transition.id = transition
        answered = Flag()
        future = client.call_async(request)
        future.add_done_callback(lambda _: answered.set())
        while not answered.wait(_LOOK_AT_THE_END_EVERY_S):
            if self._ending.is_set():
                return True
        response = future.result()
        return response is not None and response.success


@dataclass(frozen=True, slots=True)
class _Failed:
    """Event with the error text of a failed transition."""

    link: LifecycleLink
    text: str
