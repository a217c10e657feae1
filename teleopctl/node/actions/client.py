"""Action clients, and the handles of the goals that they send."""

from __future__ import annotations

import threading
import uuid
import weakref
from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING, Any, Generic, Protocol, Self, cast
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import (
    FeedbackMessage,
    FeedbackT,
    GoalT,
    ResultT,
    deserialize,
    get_message,
)
from teleopctl.node.actions.goal_state import FEEDBACK_QOS, GoalState, goal_key
from teleopctl.node.endpoints.waitable import NumberOfEntities
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.qos import (
    QoSProfile,
    qos_profile_action_status_default,
    qos_profile_services_default,
)

if TYPE_CHECKING:
    from action_msgs.msg import GoalStatusArray
    from action_msgs.srv import CancelGoal
    from builtin_interfaces.msg import Time
    from unique_identifier_msgs.msg import UUID

    from teleopctl.interfaces import ActionType, ResultResponse
    from teleopctl.node.endpoints.client import ResponseFuture
    from teleopctl.node.node_endpoints import NodeEndpoints
    from teleopctl.wire import Graph


FeedbackCallback = Callable[[FeedbackMessage[FeedbackT]], object]


class FeedbackCallbacks(Generic[FeedbackT]):
    """Feedback callbacks of a client's goals.

    A goal's feedback ends with its result. What came before the result and still waits for the
    executor then is delivered; what comes later is not.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._callbacks: dict[bytes, FeedbackCallback[FeedbackT]] = {}
        # After which message a goal's feedback ends, and what is done then.
        self._last: dict[bytes, tuple[int, Callable[[], object]]] = {}
        self._taken = 0

    def add(self, key: bytes, callback: FeedbackCallback[FeedbackT]) -> None:
        """Register a feedback callback for a goal, accepted already or not."""
        with self._lock:
            self._callbacks[key] = callback

    def end(self, key: bytes, waiting: int = 0, then: Callable[[], object] = lambda: None) -> None:
        """Unregister a goal's callback after the queued feedback was handled.

        Args:
            key: The goal's.
            waiting: Messages that wait, of whatever goals.
            then: Called when they have been taken; at once where nobody wants them.
        """
        with self._lock:
            if waiting and key in self._callbacks:
                self._last[key] = (self._taken + waiting, then)
                return
            self._callbacks.pop(key, None)
        then()

    def call(self, message: FeedbackMessage[FeedbackT] | None) -> object:
        """Call the callback of a feedback message's goal; None stands for an unreadable message.

        Returns:
            What the callback returns, which may be a coroutine.
        """
        with self._lock:
            self._taken += 1
            taken = self._taken
            callback = None if message is None else self._callbacks.get(goal_key(message.goal_id))
        try:
            return None if message is None or callback is None else callback(message)
        finally:
            if self._last:
                self._end_goals(taken)

    def _end_goals(self, taken: int) -> None:
        with self._lock:
            ended = [key for key, (last, _) in self._last.items() if last <= taken]
            thens = [self._last.pop(key)[1] for key in ended]
            for key in ended:
                self._callbacks.pop(key, None)
        for then in thens:
            then()


class GoalResponseMessage(Protocol):
    """Response of an action server to a goal request."""

    accepted: bool

    @property
    def stamp(self) -> Time:
        """Time at which the server accepted the goal."""


class GoalClient(Protocol[ResultT]):
    """The requests of an action client that goal handles send."""

    def cancel(self, goal_id: UUID) -> ResponseFuture[CancelGoal.Response]:
        """Send a request to cancel a goal."""

    def ask_for_result(
        self, goal_id: UUID, *, at_once: bool = False
    ) -> ResponseFuture[ResultResponse[ResultT]]:
        """Send a request for the result of a goal."""


class ClientGoalHandle(Generic[ResultT]):
    """Client's handle of a goal that was sent, with the server's response.

    Args:
        action_client: Who sent it.
        goal_id: Its id.
        goal_response: The answer.
    """

    def __init__(
        self,
        action_client: GoalClient[ResultT],
        goal_id: UUID,
        goal_response: GoalResponseMessage,
    ) -> None:
        self._client = action_client
        self._goal_id = goal_id
        self._response = goal_response
        self._key = goal_key(goal_id)
        self._state = GoalState.UNKNOWN

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ClientGoalHandle) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    def __repr__(self) -> str:
        return (
            f"ClientGoalHandle <id={list(self._key)}, accepted={self.accepted}, "
            f"status={self.status}>"
        )

    @property
    def goal_id(self) -> UUID:
        """Id of the goal."""
        return self._goal_id

    @property
    def stamp(self) -> Time:
        """Time at which the server accepted the goal."""
        return self._response.stamp

    @property
    def accepted(self) -> bool:
        """Whether the server accepted the goal."""
        return self._response.accepted

    @property
    def status(self) -> int:
        """Last reported status of the goal, a number of action_msgs/msg/GoalStatus."""
        return int(self._state)

    def follow(self, state: GoalState) -> None:
        """Store the status that the server reports for the goal (ours)."""
        self._state = state

    def cancel_goal_async(self) -> ResponseFuture[CancelGoal.Response]:
        """Send a request to cancel the goal.

        Returns:
            A future of the answer; the goal is being cancelled if ``goals_canceling`` holds it.
        """
        return self._client.cancel(self._goal_id)

    def cancel_goal(self) -> CancelGoal.Response | None:
        """Send a request to cancel the goal, and wait for the response.

        Raises:
            ExternalShutdownException: The context was shut down meanwhile.
        """
        return self.cancel_goal_async().wait_until_answered()

    def get_result_async(self) -> ResponseFuture[ResultResponse[ResultT]]:
        """Send a request for the goal's final status and result.

        Returns:
            A future of the answer, which comes when the goal has ended and the callbacks of the
            feedback that came before have been called.
        """
        return self._client.ask_for_result(self._goal_id)

    def get_result(self) -> ResultResponse[ResultT] | None:
        """Request the goal's final status and result, and wait for the response.

        Raises:
            ExternalShutdownException: The context was shut down meanwhile.
        """
        return self._client.ask_for_result(self._goal_id, at_once=True).wait_until_answered()


class ActionClient(Generic[GoalT, ResultT, FeedbackT]):
    """Client of an action: sends goals and receives feedback and results.

    As with rclpy, the futures of a goal whose server is missing or goes away stay pending; unlike
    there, a warning says so. Waiting calls may be used in callbacks: answers do not need the
    executor.

    Args:
        node: Owner.
        action_type: Action class.
        action_name: Relative, absolute or private name.
        callback_group: Of the callbacks of feedback and futures; the node's default one if None.
        goal_service_qos_profile: Of the service that takes goals.
        result_service_qos_profile: Of the service that gives results.
        cancel_service_qos_profile: Of the service that cancels.
        feedback_sub_qos_profile: Of the feedback.
        status_sub_qos_profile: Of the states of goals.

    Raises:
        InvalidServiceNameException: The name breaks a rule.
    """

    def __init__(
        self,
        node: NodeEndpoints,
        action_type: type[ActionType[GoalT, ResultT, FeedbackT]],
        action_name: str,
        *,
        callback_group: CallbackGroup | None = None,
        goal_service_qos_profile: QoSProfile = qos_profile_services_default,
        result_service_qos_profile: QoSProfile = qos_profile_services_default,
        cancel_service_qos_profile: QoSProfile = qos_profile_services_default,
        feedback_sub_qos_profile: QoSProfile = FEEDBACK_QOS,
        status_sub_qos_profile: QoSProfile = qos_profile_action_status_default,
    ) -> None:
        self._node = node
        # A class is a value whose attributes are classes.
        self._action_type = cast("ActionType[GoalT, ResultT, FeedbackT]", action_type)
        self._logger = node.get_logger().get_child("action_client")
        self._lock = threading.Lock()
        self._callbacks: FeedbackCallbacks[FeedbackT] = FeedbackCallbacks()
        # The states of goals that are not answered yet, which may be told before the answer.
        self._unanswered: dict[bytes, GoalState] = {}
        self._handles: weakref.WeakValueDictionary[bytes, ClientGoalHandle[ResultT]]
        self._handles = weakref.WeakValueDictionary()
        parts = self._action_type.Impl

        # Any: the services of whatever action it is.
        def client(type_: type[Any], name: str, qos: QoSProfile) -> Any:
            name = f"{action_name}/_action/{name}"
            return node.create_client(type_, name, qos_profile=qos, callback_group=callback_group)

        self._goals = client(parts.SendGoalService, "send_goal", goal_service_qos_profile)
        self._cancels = client(parts.CancelGoalService, "cancel_goal", cancel_service_qos_profile)
        self._results = client(parts.GetResultService, "get_result", result_service_qos_profile)
        self._feedback = node.create_subscription(
            parts.FeedbackMessage,
            f"{action_name}/_action/feedback",
            self._pass_feedback_on,
            feedback_sub_qos_profile,
            callback_group=callback_group,
            raw=True,  # each one counts, also one that cannot be read
        )
        self._status = node.create_subscription(
            parts.GoalStatusMessage,
            f"{action_name}/_action/status",
            self._follow_states,
            status_sub_qos_profile,
            callback_group=callback_group,
        )

    @property
    def node(self) -> NodeEndpoints:
        """Node of the client (ours)."""
        return self._node

    @property
    def action_name(self) -> str:
        """The fully qualified name of the action (ours)."""
        return self._feedback.topic_name.removesuffix("/_action/feedback")

    def get_num_entities(self) -> NumberOfEntities:
        """Return the numbers of entities that an executor waits for, as rclpy counts them."""
        return NumberOfEntities(num_subs=2, num_clients=3)

    # -- servers ---------------------------------------------------------------------------------

    def server_is_ready(self) -> bool:
        """Return whether an action server of the client's name and type is in the graph."""
        return self._is_served(self._node.graph())

    def wait_for_server(self, timeout_sec: float | None = None) -> bool:
        """Wait until a server is in the graph, for some seconds of wall time.

        Returns:
            False when the time ran out or the context was shut down.
        """
        timeout_s = None if timeout_sec is None else max(0.0, timeout_sec)
        return self._node.context.wait_for_graph(self._is_served, timeout_s)

    def _is_served(self, graph: Graph) -> bool:
        services = (self._goals, self._cancels, self._results)
        topics = (self._feedback, self._status)
        return all(graph.servers(one.name, one.type_name) for one in services) and all(
            graph.publishers(one.name, one.type_name) for one in topics
        )

    # -- goals -----------------------------------------------------------------------------------

    def send_goal_async(
        self,
        goal: GoalT,
        feedback_callback: FeedbackCallback[FeedbackT] | None = None,
        goal_uuid: UUID | None = None,
    ) -> ResponseFuture[ClientGoalHandle[ResultT]]:
        """Send a goal.

        Args:
            goal: A goal of the client's action.
            feedback_callback: ``callback(message)`` for each feedback; the message has the
                ``goal_id`` besides the ``feedback``. The first may come before the answer.
            goal_uuid: Its id; a random one if None.

        Returns:
            A future of its handle, which tells whether the server has accepted it.

        Raises:
            TypeError: The goal is of another type.
            InvalidHandle: The client was destroyed.
        """
        self._check(goal)
        request = self._action_type.Impl.SendGoalService.Request(
            goal_id=goal_uuid
            or get_message("unique_identifier_msgs/msg/UUID")(uuid=uuid.uuid4().bytes),
            goal=goal,
        )
        key = goal_key(request.goal_id)
        with self._lock:
            self._unanswered[key] = GoalState.UNKNOWN
        if feedback_callback is not None:
            self._callbacks.add(key, feedback_callback)
        response = self._goals.call_async(request)
        future: ResponseFuture[ClientGoalHandle[ResultT]] = self._goals.make_future()
        response.on_end(lambda: self._take_answer(key, request.goal_id, response, future))
        response.when_unanswered(lambda: self._miss_server(future, f"goal {key.hex()}"))
        return future

    def send_goal(
        self,
        goal: GoalT,
        feedback_callback: FeedbackCallback[FeedbackT] | None = None,
        goal_uuid: UUID | None = None,
    ) -> ResultResponse[ResultT] | None:
        """Send a goal and wait for its result.

        Returns:
            The end state with the result; the state is 0 where the goal was not accepted.

        Raises:
            TypeError: The goal is of another type.
            ExternalShutdownException: The context was shut down meanwhile.
        """
        answer = self.send_goal_async(goal, feedback_callback, goal_uuid).wait_until_answered()
        return None if answer is None else answer.get_result()

    def _check(self, goal: object) -> None:
        if not isinstance(goal, self._action_type.Goal):
            raise TypeError(f"Expected {self._action_type.Goal}, got {type(goal)}")

    def _take_answer(
        self,
        key: bytes,
        goal_id: UUID,
        response: ResponseFuture[Any],  # Any: of whatever action it is
        future: ResponseFuture[ClientGoalHandle[ResultT]],
    ) -> None:
        """Make the handle of a goal that was answered; on the thread that brought the answer."""
        answer = response.result()
        if answer is None:
            with self._lock:
                self._unanswered.pop(key, None)
            self._callbacks.end(key)
            future.cancel()
            return
        handle: ClientGoalHandle[ResultT] = ClientGoalHandle(self, goal_id, answer)
        with self._lock:
            handle.follow(self._unanswered.pop(key, GoalState.UNKNOWN))
            is_new = not answer.accepted or self._handles.setdefault(key, handle) is handle
        if not answer.accepted:
            self._callbacks.end(key)
        if is_new:
            future.set_result(handle)
        else:
            future.set_exception(
                RuntimeError(f"Two goals were accepted with the same ID ({handle})")
            )

    def cancel(self, goal_id: UUID) -> ResponseFuture[CancelGoal.Response]:
        """Request the cancellation of a goal, of this client or of another one (ours)."""
        request = self._action_type.Impl.CancelGoalService.Request()
        request.goal_info.goal_id = goal_id
        future: ResponseFuture[CancelGoal.Response] = self._cancels.call_async(request)
        return future

    def ask_for_result(
        self, goal_id: UUID, *, at_once: bool = False
    ) -> ResponseFuture[ResultResponse[ResultT]]:
        """Request the final status and result of a goal, of this client or of another one (ours).

        Args:
            goal_id: Its id.
            at_once: Not to wait until an executor has passed on the feedback that came before, for
                who blocks the executor meanwhile.
        """
        request = self._action_type.Impl.GetResultService.Request(goal_id=goal_id)
        response: ResponseFuture[ResultResponse[ResultT]] = self._results.call_async(request)
        future: ResponseFuture[ResultResponse[ResultT]] = self._results.make_future()
        key = goal_key(goal_id)

        def pass_on() -> None:
            answer = response.result()
            if answer is None:
                future.cancel()
            else:
                future.set_result(answer)

        def take() -> None:
            waiting = 0 if self._node.executor is None else self._feedback.pending()
            if at_once:
                pass_on()
            self._callbacks.end(key, waiting, (lambda: None) if at_once else pass_on)

        response.on_end(take)
        what = f"the request for the result of goal {key.hex()}"
        response.when_unanswered(lambda: self._miss_server(future, what))
        return future

    # Any: of whatever is waited for.
    def _miss_server(self, future: ResponseFuture[Any], what: str) -> None:
        """Say that nobody will answer; the future stays pending, as rclpy's."""
        if self._node.context.ok() and not self._goals.is_destroyed:
            self._logger.warning(
                f"No server of action '{self.action_name}' answers {what}: "
                "none is there, or it has gone away."
            )
        future.reached_nobody()

    def feedback_waiting(self) -> int:
        """Return how many feedback messages are queued for the executor (ours)."""
        return self._feedback.pending()

    # -- topics ----------------------------------------------------------------------------------

    def _pass_feedback_on(self, data: bytes) -> object:
        try:
            message = deserialize(data, self._action_type.Impl.FeedbackMessage)
        except TeleopctlError as error:
            self._feedback.refusals.refuse(error.message)
            message = None
        return self._callbacks.call(message)

    def _follow_states(self, message: GoalStatusArray) -> None:
        with self._lock:
            meant = {*self._handles, *self._unanswered}
        # The youngest stand at the end, behind all that ended in the last quarter of an hour.
        for entry in reversed(message.status_list):
            if not meant:
                return
            key = goal_key(entry.goal_info.goal_id)
            if key in meant:
                meant.discard(key)
                self._follow_state(key, entry.status)

    def _follow_state(self, key: bytes, number: int) -> None:
        try:
            state = GoalState(number)
        except ValueError:  # no state that there is
            return
        with self._lock:
            if (handle := self._handles.get(key)) is not None:
                handle.follow(state)
            elif key in self._unanswered:
                self._unanswered[key] = state

    def destroy(self) -> None:
        """Cancel what is pending and remove the client from the graph. Idempotent."""
        self._node.destroy_subscription(self._status)
        self._node.destroy_subscription(self._feedback)
        for client in (self._results, self._cancels, self._goals):
            self._node.destroy_client(client)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()
