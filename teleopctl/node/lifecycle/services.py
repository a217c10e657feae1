"""Services and transition-event topic of lifecycle nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.interfaces import get_message, get_service
from teleopctl.node.lifecycle.states import (
    STATES,
    TRANSITIONS,
    LifecycleState,
    StateMachine,
    Transition,
    TransitionCallbackReturn,
    TransitionNotPossibleError,
)
from teleopctl.node.values.qos import QoSProfile

if TYPE_CHECKING:
    from teleopctl.node.endpoints.service import Service
    from teleopctl.node.node import Node
    from teleopctl.node.values.callback_groups import CallbackGroup


class LifecycleStateMachine(StateMachine):
    """Life cycle state machine of a node, with its services and its transition-event topic.

    The attributes ``service_…`` and ``current_state`` are those of rclpy's state machine.

    Args:
        node: The lifecycle node.
        is_served: Whether to offer the services and the topic.
        group: Callback group of the services.
        change: Function that runs a transition, given by ID or label.

    Attributes:
        service_change_state: Service server; it and the following are None unless ``is_served``.
    """

    # Any, here and below: requests and responses of lifecycle_msgs, whose classes are generated on
    # first use.
    service_change_state: Service[Any, Any] | None = None
    service_get_state: Service[Any, Any] | None = None
    service_get_available_states: Service[Any, Any] | None = None
    service_get_available_transitions: Service[Any, Any] | None = None
    service_get_transition_graph: Service[Any, Any] | None = None

    def __init__(
        self,
        node: Node,
        *,
        is_served: bool,
        group: CallbackGroup,
        change: Callable[[int | str], TransitionCallbackReturn],
    ) -> None:
        super().__init__(self._publish_step)
        self._node = node
        self._group = group
        self._change = change
        self._events: Any = None
        if not is_served:
            return
        self._event_class = get_message("lifecycle_msgs/msg/TransitionEvent")
        self._state_class = get_message("lifecycle_msgs/msg/State")
        self._transition_class = get_message("lifecycle_msgs/msg/TransitionDescription")
        # In the order of rcl_lifecycle.
        self._events = node.create_publisher(
            self._event_class, "~/transition_event", QoSProfile(depth=10)
        )
        self.service_change_state = self._serve("ChangeState", "change_state", self._on_change)
        self.service_get_state = self._serve("GetState", "get_state", self._on_get_state)
        self.service_get_available_states = self._serve(
            "GetAvailableStates", "get_available_states", self._on_get_states
        )
        self.service_get_available_transitions = self._serve(
            "GetAvailableTransitions", "get_available_transitions", self._on_get_transitions
        )
        self.service_get_transition_graph = self._serve(
            "GetAvailableTransitions", "get_transition_graph", self._on_get_graph
        )

    @property
    def current_state(self) -> tuple[int, str]:
        """Id and label of the present state, as in rclpy."""
        return self.state.state_id, self.state.label

    def _serve(self, type_: str, name: str, callback: Callable[[Any, Any], Any]) -> Any:
        service = get_service(f"lifecycle_msgs/srv/{type_}")
        return self._node.create_service(service, f"~/{name}", callback, callback_group=self._group)

    def _publish_step(self, before: LifecycleState, after: LifecycleState) -> None:
        # As in ROS 2, only the two states are set: time stamp and transition stay empty.
        if self._events is not None:
            event = self._event_class()
            event.start_state = self._message(before)
            event.goal_state = self._message(after)
            self._events.publish(event)

    def _on_change(self, request: Any, response: Any) -> Any:
        transition = request.transition.label or request.transition.id
        try:
            outcome = self._change(transition)
        except TransitionNotPossibleError as error:
            # In rclpy this ends the node; here the client receives success=False.
            self._node.get_logger().error(str(error))
            response.success = False
        else:
            response.success = outcome is TransitionCallbackReturn.SUCCESS
        return response

    def _on_get_state(self, _request: Any, response: Any) -> Any:
        response.current_state = self._message(self.state)
        return response

    def _on_get_states(self, _request: Any, response: Any) -> Any:
        response.available_states = [self._message(state) for state in STATES]
        return response

    def _on_get_transitions(self, _request: Any, response: Any) -> Any:
        response.available_transitions = self._described(self.available())
        return response

    def _on_get_graph(self, _request: Any, response: Any) -> Any:
        response.available_transitions = self._described(TRANSITIONS)
        return response

    def _message(self, state: LifecycleState) -> Any:
        return self._state_class(id=state.state_id, label=state.label)

    def _described(self, transitions: Iterable[Transition]) -> list[Any]:
        transition_class = get_message("lifecycle_msgs/msg/Transition")
        return [
            self._transition_class(
                transition=transition_class(id=each.id, label=each.label),
                start_state=self._message(each.start),
                goal_state=self._message(each.goal),
            )
            for each in transitions
        ]
