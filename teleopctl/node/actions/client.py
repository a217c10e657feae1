"""Action clients, and handles of the goals that they send."""

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
    """Registry of an action client's feedback callbacks, at most one for each goal.

    A goal's feedback ends with its result: messages received before the result are delivered, even
    if they still wait for the executor; later messages are dropped.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._callbacks: dict[bytes, FeedbackCallback[FeedbackT]] = {}
        # Number of the last feedback message of ended goals, and the function called after it.
        self._last: dict[bytes, tuple[int, Callable[[], object]]] = {}
        self._taken = 0

    def add(self, key: bytes, callback: FeedbackCallback[FeedbackT]) -> None:
        """Set the feedback callback of a goal, which need not be accepted yet, by `goal_key`."""
        with self._lock:
            self._callbacks[key] = callback

    def remove(
        self,
        key: bytes,
        count_queued: Callable[[], int] = lambda: 0,
        on_removed: Callable[[], object] = lambda: None,
    ) -> None:
        """Unregister a goal's callback after the queued messages; then call ``on_removed``.

        Args:
            key: Id of the goal, see `goal_key`.
            count_queued: Function that returns how many feedback messages, of all goals, wait for
                the executor.
            on_removed: Called once these messages were handled; at once if the goal has no
                callback.
        """
        with self._lock:
            # Counted under the lock: a message that is handled in between would be waited for.
            if key in self._callbacks and (queued := count_queued()):
                self._last[key] = (self._taken + queued, on_removed)
                return
            self._callbacks.pop(key, None)
        on_removed()

    def dispatch(self, message: FeedbackMessage[FeedbackT] | None) -> object:
        """Call the callback of the message's goal, if any, and return its result; else None.

        A malformed message, None, is counted too; goals whose last feedback this was are removed.

        Returns:
            The callback's return value, which may be a coroutine; None without a callback.
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
    """Interface of the response to a goal request: whether and when the goal was accepted."""

    accepted: bool

    @property
    def stamp(self) -> Time:
        """Time at which the server accepted the goal, as a ``builtin_interfaces/msg/Time``."""


class GoalClient(Protocol[ResultT]):
    """Interface of an action client as goal handles use it: cancel and result requests."""

    def request_cancel(self, goal_id: UUID) -> ResponseFuture[CancelGoal.Response]:
        """Send a request to cancel a goal; return a future of the response."""

    def request_result(
        self, goal_id: UUID, *, immediate: bool = False
    ) -> ResponseFuture[ResultResponse[ResultT]]:
        """Request the result of a goal; return a future of the response at the goal's end."""


class ClientGoalHandle(Generic[ResultT]):
    """Handle of a goal that an action client sent, accepted or rejected by the server.

    Args:
        action_client: Action client that sent the goal.
        goal_id: Id of the goal.
        goal_response: Response of the server to the goal request.
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
        """Time at which the server accepted the goal, as a ``builtin_interfaces/msg/Time``."""
        return self._response.stamp

    @property
    def accepted(self) -> bool:
        """Whether the server accepted the goal."""
        return self._response.accepted

    @property
    def status(self) -> int:
        """Last received status of the goal, numbered as in GoalStatus; 0 before the first one."""
        return int(self._state)

    def update_status(self, state: GoalState) -> None:
        """Store the goal status that the server published (ours)."""
        self._state = state

    def cancel_goal_async(self) -> ResponseFuture[CancelGoal.Response]:
        """Send a request to cancel the goal; return a future of the response.

        Returns:
            A future of the response; if ``goals_canceling`` contains the goal, it is canceling.
        """
        return self._client.request_cancel(self._goal_id)

    def cancel_goal(self) -> CancelGoal.Response | None:
        """Send a cancel request for the goal; block, without a timeout, and return the response.

        Raises:
            ExternalShutdownException: The context was shut down during the wait.
        """
        return self.cancel_goal_async().wait_until_answered()

    def get_result_async(self) -> ResponseFuture[ResultResponse[ResultT]]:
        """Request the goal's final status and result; return a future of the response.

        Returns:
            A future of the response, which completes when the goal has ended and the callbacks of
            all feedback received before have been called.
        """
        return self._client.request_result(self._goal_id)

    def get_result(self) -> ResultResponse[ResultT] | None:
        """Request the goal's result, block until the goal has ended; return status and result.

        Raises:
            ExternalShutdownException: The context was shut down during the wait.
        """
        return self._client.request_result(self._goal_id, immediate=True).wait_until_answered()


class ActionClient(Generic[GoalT, ResultT, FeedbackT]):
    """Client of an action: sends goals and receives feedback and results.

    As in rclpy, the futures of a goal stay pending if its server is missing or disappears; unlike
    in rclpy, a warning is logged. Blocking calls may be used in callbacks: responses do not need
    the executor.

    Args:
        node: Node of the client.
        action_type: Action class.
        action_name: Relative, absolute or private name of the action.
        callback_group: Callback group of feedback and futures; the node's default group if None.
        goal_service_qos_profile: QoS of the goal service's client.
        result_service_qos_profile: QoS of the result service's client.
        cancel_service_qos_profile: QoS of the cancel service's client.
        feedback_sub_qos_profile: QoS of the feedback subscription.
        status_sub_qos_profile: QoS of the goal status subscription.

    Raises:
        InvalidServiceNameException: The name is malformed.
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
        # For type checkers, an action class is an object whose attributes are classes.
        self._action_type = cast("ActionType[GoalT, ResultT, FeedbackT]", action_type)
        # rclpy's attribute, which programs such as pymoveit2 read for their messages.
        self._action_name = action_name
        self._logger = node.get_logger().get_child("action_client")
        self._lock = threading.Lock()
        self._callbacks: FeedbackCallbacks[FeedbackT] = FeedbackCallbacks()
        # States of goals without a response yet; the status topic may be faster.
        self._unanswered: dict[bytes, GoalState] = {}
        self._handles: weakref.WeakValueDictionary[bytes, ClientGoalHandle[ResultT]]
        self._handles = weakref.WeakValueDictionary()
        parts = self._action_type.Impl

        # Any: the services of any action.
        def client(type_: type[Any], name: str, qos: QoSProfile) -> Any:
            name = f"{action_name}/_action/{name}"
            return node.create_client(type_, name, qos_profile=qos, callback_group=callback_group)

        self._goals = client(parts.SendGoalService, "send_goal", goal_service_qos_profile)
        self._cancels = client(parts.CancelGoalService, "cancel_goal", cancel_service_qos_profile)
        self._results = client(parts.GetResultService, "get_result", result_service_qos_profile)
        self._feedback = node.create_subscription(
            parts.FeedbackMessage,
            f"{action_name}/_action/feedback",
            self._dispatch_feedback,
            feedback_sub_qos_profile,
            callback_group=callback_group,
            raw=True,  # malformed messages are counted too
        )
        self._status = node.create_subscription(
            parts.GoalStatusMessage,
            f"{action_name}/_action/status",
            self._update_statuses,
            status_sub_qos_profile,
            callback_group=callback_group,
        )

    @property
    def node(self) -> NodeEndpoints:
        """Node that the client was created on (ours)."""
        return self._node

    @property
    def action_name(self) -> str:
        """Fully qualified name of the action (ours)."""
        return self._feedback.topic_name.removesuffix("/_action/feedback")

    def get_num_entities(self) -> NumberOfEntities:
        """Return the entity numbers of the action client: 2 subscriptions and 3 service clients."""
        return NumberOfEntities(num_subs=2, num_clients=3)

    # -- servers ---------------------------------------------------------------------------------

    def server_is_ready(self) -> bool:
        """Return whether a server of the client's action name and type is in the graph."""
        return self._is_served(self._node.graph())

    def wait_for_server(self, timeout_sec: float | None = None) -> bool:
        """Block until a server of the action is in the graph; False on timeout or shutdown."""
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
        """Send a goal to the action server; return a future of the handle, also if rejected.

        Args:
            goal: Goal message of the client's action.
            feedback_callback: ``callback(message)`` for each feedback message, which has the fields
                ``goal_id`` and ``feedback``. The first may arrive before the goal response.
            goal_uuid: Id of the goal; a random one if None.

        Returns:
            A future of the goal handle, whose ``accepted`` is the server's decision.

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
        response.on_end(lambda: self._accept_response(key, request.goal_id, response, future))
        response.on_unanswered(lambda: self._warn_unanswered(future, f"goal {key.hex()}"))
        return future

    def send_goal(
        self,
        goal: GoalT,
        feedback_callback: FeedbackCallback[FeedbackT] | None = None,
        goal_uuid: UUID | None = None,
    ) -> ResultResponse[ResultT] | None:
        """Send a goal, block until its end or rejection, and return the status and the result.

        Returns:
            The response with final status and result; the status is 0 if the goal was not accepted.

        Raises:
            TypeError: The goal is of another type.
            ExternalShutdownException: The context was shut down during the wait.
        """
        answer = self.send_goal_async(goal, feedback_callback, goal_uuid).wait_until_answered()
        return None if answer is None else answer.get_result()

    def _check(self, goal: object) -> None:
        if not isinstance(goal, self._action_type.Goal):
            raise TypeError(f"Expected {self._action_type.Goal}, got {type(goal)}")

    def _accept_response(
        self,
        key: bytes,
        goal_id: UUID,
        response: ResponseFuture[Any],  # Any: of any action
        future: ResponseFuture[ClientGoalHandle[ResultT]],
    ) -> None:
        """Complete a goal's future after the response, on the thread that received the response."""
        answer = response.result()
        if answer is None:
            with self._lock:
                self._unanswered.pop(key, None)
            self._callbacks.remove(key)
            future.cancel()
            return
        handle: ClientGoalHandle[ResultT] = ClientGoalHandle(self, goal_id, answer)
        with self._lock:
            handle.update_status(self._unanswered.pop(key, GoalState.UNKNOWN))
            is_new = not answer.accepted or self._handles.setdefault(key, handle) is handle
        if not answer.accepted:
            self._callbacks.remove(key)
        if is_new:
            future.set_result(handle)
        else:
            future.set_exception(
                RuntimeError(f"Two goals were accepted with the same ID ({handle})")
            )

    def request_cancel(self, goal_id: UUID) -> ResponseFuture[CancelGoal.Response]:
        """Send a request to cancel a goal of any client; return a future of the response (ours)."""
        request = self._action_type.Impl.CancelGoalService.Request()
        request.goal_info.goal_id = goal_id
        future: ResponseFuture[CancelGoal.Response] = self._cancels.call_async(request)
        return future

    def request_result(
        self, goal_id: UUID, *, immediate: bool = False
    ) -> ResponseFuture[ResultResponse[ResultT]]:
        """Request the result of a goal of any client; return a future of the response (ours).

        Args:
            goal_id: Id of the goal.
            immediate: Whether to complete the future before the executor has handled the feedback
                received before; for callers that block the executor.
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

        def count_queued() -> int:
            return 0 if self._node.executor is None else self._feedback.pending()

        def take() -> None:
            if immediate:
                pass_on()
            self._callbacks.remove(key, count_queued, (lambda: None) if immediate else pass_on)

        response.on_end(take)
        what = f"the request for the result of goal {key.hex()}"
        response.on_unanswered(lambda: self._warn_unanswered(future, what))
        return future

    # Any: a future of any response.
    def _warn_unanswered(self, future: ResponseFuture[Any], what: str) -> None:
        """Log that no server will respond; the future stays pending, as rclpy's."""
        if self._node.context.ok() and not self._goals.is_destroyed:
            self._logger.warning(
                f"No server of action '{self.action_name}' answers {what}: "
                "none is there, or it has disappeared."
            )
        future.mark_unanswered()

    def queued_feedback(self) -> int:
        """Return how many feedback messages, of all goals, wait for the executor (ours)."""
        return self._feedback.pending()

    # -- topics ----------------------------------------------------------------------------------

    def _dispatch_feedback(self, data: bytes) -> object:
        try:
            message = deserialize(data, self._action_type.Impl.FeedbackMessage)
        except TeleopctlError as error:
            self._feedback.refusals.refuse(error.message)
            message = None
        return self._callbacks.dispatch(message)

    def _update_statuses(self, message: GoalStatusArray) -> None:
        with self._lock:
            meant = {*self._handles, *self._unanswered}
        # The newest goals are last, after all that ended in the last quarter of an hour.
        for entry in reversed(message.status_list):
            if not meant:
                return
            key = goal_key(entry.goal_info.goal_id)
            if key in meant:
                meant.discard(key)
                self._update_status(key, entry.status)

    def _update_status(self, key: bytes, number: int) -> None:
        try:
            state = GoalState(number)
        except ValueError:  # an unknown status
            return
        with self._lock:
            if (handle := self._handles.get(key)) is not None:
                handle.update_status(state)
            elif key in self._unanswered:
                self._unanswered[key] = state

    def destroy(self) -> None:
        """Remove the client from the graph, and cancel pending futures. Idempotent."""
        self._node.destroy_subscription(self._status)
        self._node.destroy_subscription(self._feedback)
        for client in (self._results, self._cancels, self._goals):
            self._node.destroy_client(client)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()
