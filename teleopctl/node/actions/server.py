"""Action servers, with their callbacks and the selection of goals to cancel.

Source of the cancellation policies: action_msgs/srv/CancelGoal.
"""

from __future__ import annotations

import collections
import enum
import functools
import threading
from collections.abc import Awaitable, Callable, Coroutine, Iterable

from teleopctl.base.typed import (
    TYPE_CHECKING,
    Any,
    Generic,
    Protocol,
    Self,
    TypeAlias,
    TypeVar,
    cast,
)
from teleopctl.interfaces import (
    FeedbackT,
    GoalT,
    ResultT,
    from_seconds,
    get_message,
    set_stamp,
    to_nanoseconds,
)
from teleopctl.node.actions.goal_state import (
    FEEDBACK_QOS,
    GoalEvent,
    GoalState,
    InvalidGoalTransitionError,
    goal_key,
    next_state as _next_state,
)
from teleopctl.node.actions.server_goal import ExecuteCallback, ServerGoalHandle
from teleopctl.node.endpoints.service import DeferringService
from teleopctl.node.endpoints.waitable import NumberOfEntities
from teleopctl.node.values.callback_groups import CallbackGroup, ReentrantCallbackGroup
from teleopctl.node.values.qos import (
    QoSProfile,
    qos_profile_action_status_default,
    qos_profile_services_default,
)

if TYPE_CHECKING:
    from action_msgs.srv import CancelGoal
    from unique_identifier_msgs.msg import UUID

    from teleopctl.interfaces import ActionType
    from teleopctl.node.node_endpoints import NodeEndpoints


class GoalResponse(enum.Enum):
    """Return value of a goal callback: accept or reject the goal."""

    REJECT = 1
    ACCEPT = 2


class CancelResponse(enum.Enum):
    """Return value of a cancel callback: accept or reject the cancel request."""

    REJECT = 1
    ACCEPT = 2


GoalCallback: TypeAlias = Callable[[GoalT], GoalResponse | Awaitable[GoalResponse]]
CancelCallback: TypeAlias = Callable[
    [ServerGoalHandle[GoalT, ResultT, FeedbackT]], CancelResponse | Awaitable[CancelResponse]
]
AcceptedCallback: TypeAlias = Callable[[ServerGoalHandle[GoalT, ResultT, FeedbackT]], object]


def default_handle_accepted_callback(
    goal_handle: ServerGoalHandle[GoalT, ResultT, FeedbackT],
) -> None:
    """Schedule the execution of an accepted goal; the default callback for accepted goals."""
    goal_handle.execute()


def default_goal_callback(goal_request: GoalT) -> GoalResponse:  # noqa: ARG001 (rclpy's signature)
    """Accept every goal; the default goal callback."""
    return GoalResponse.ACCEPT


def default_cancel_callback(
    cancel_request: ServerGoalHandle[GoalT, ResultT, FeedbackT],  # noqa: ARG001 (rclpy's signature)
) -> CancelResponse:
    """Reject every cancel request; the default cancel callback."""
    return CancelResponse.REJECT


ERROR_NONE = 0
ERROR_UNKNOWN_GOAL_ID = 2
ERROR_GOAL_TERMINATED = 3

_NO_ID = bytes(16)


class CancelableGoal(Protocol):
    """Interface of a server's goals as `goals_to_cancel` reads them."""

    @property
    def key(self) -> bytes:
        """UUID bytes of the goal id."""

    @property
    def stamp_ns(self) -> int:
        """Time at which the server accepted the goal, in nanoseconds of the node's clock."""

    @property
    def state(self) -> GoalState:
        """State of the goal."""


CancelableGoalT = TypeVar("CancelableGoalT", bound=CancelableGoal)


def goals_to_cancel(
    goals: Iterable[CancelableGoalT], key: bytes, stamp_ns: int
) -> tuple[int, list[CancelableGoalT]]:
    """Return a CancelGoal response's return code, and the cancelable goals that are requested.

    Args:
        goals: All goals of the server, the oldest first.
        key: Id in the request; zeros for none.
        stamp_ns: Time in the request in nanoseconds; 0 for none. Selects the goals accepted until
            that time and the goal with the id. Without id and time, all goals are selected.
    """
    if key != _NO_ID and stamp_ns == 0:
        for goal in goals:
            if goal.key == key:
                return (ERROR_NONE, [goal]) if _can_be(goal) else (ERROR_GOAL_TERMINATED, [])
        return ERROR_UNKNOWN_GOAL_ID, []
    are_all = key == _NO_ID and stamp_ns == 0
    meant = [g for g in goals if are_all or g.stamp_ns <= stamp_ns or g.key == key]
    return ERROR_NONE, [goal for goal in meant if _can_be(goal)]


def _can_be(goal: CancelableGoal) -> bool:
    try:
        _next_state(goal.state, GoalEvent.CANCEL_GOAL)
    except InvalidGoalTransitionError:
        return False
    return True


OutcomeT = TypeVar("OutcomeT")


class ExecutionQueue:
    """Queue of goals' execution coroutines, which wait until the node's executor starts them.

    So goals also begin in a program that spins its node only from time to time.
    """

    def __init__(self, node: NodeEndpoints) -> None:
        self._node = node
        self._waiting: collections.deque[Callable[[], Coroutine[object, None, None]]]
        self._waiting = collections.deque()
        self._guard = node.create_guard_condition(self._begin_next, ReentrantCallbackGroup())

    def add(self, coroutine_function: Callable[[], Coroutine[object, None, None]]) -> None:
        """Queue a coroutine function, which the node's executor will call and run; thread-safe."""
        self._waiting.append(coroutine_function)
        self._guard.trigger()

    def _begin_next(self) -> Coroutine[object, None, None] | None:
        try:
            coroutine_function = self._waiting.popleft()
        except IndexError:
            return None
        if self._waiting:
            self._guard.trigger()
        return coroutine_function()

    def destroy(self) -> None:
        """Drop the queued functions, and destroy the queue's guard condition."""
        self._waiting.clear()
        self._node.destroy_guard_condition(self._guard)


async def call_and_await(
    callback: Callable[..., OutcomeT | Awaitable[OutcomeT]], *args: object
) -> OutcomeT:
    """Call a plain or coroutine function with ``args``; await if needed, and return the result."""
    outcome = callback(*args)
    if hasattr(outcome, "__await__"):
        return await cast("Awaitable[OutcomeT]", outcome)
    return outcome


# How long the result of a goal is kept for result requests, as in rclpy.
_RESULT_TIMEOUT_S = 900


class ActionServer(Generic[GoalT, ResultT, FeedbackT]):
    """Server of an action: accepts goals, publishes feedback and sends results.

    Requests are served in the callback group. The execute callback is a task of the executor,
    outside any group: during a goal's execution the goal can be cancelled if the executor has
    another thread, or if the callback is a coroutine that awaits.

    Args:
        node: Node of the server.
        action_type: Action class.
        action_name: Relative, absolute or private name of the action.
        execute_callback: ``callback(goal_handle) -> result``; may be a coroutine function. It sets
            the final state with `ServerGoalHandle.succeed`, ``abort`` or ``canceled``; if it sets
            none or raises, the goal is aborted.
        callback_group: Callback group of the requests; the node's default group if None.
        goal_callback: ``callback(goal) -> GoalResponse``; accepts all goals by default.
        handle_accepted_callback: ``callback(goal_handle)`` for each accepted goal; executes the
            goal at once by default. Another callback has to call ``goal_handle.execute()``.
        cancel_callback: ``callback(goal_handle) -> CancelResponse``; rejects all by default.
        goal_service_qos_profile: QoS of the goal service.
        result_service_qos_profile: QoS of the result service.
        cancel_service_qos_profile: QoS of the cancel service.
        feedback_pub_qos_profile: QoS of the feedback publisher.
        status_pub_qos_profile: QoS of the goal status publisher.
        result_timeout: Time for which the result of an ended goal is kept, in seconds of the node's
            clock; forever if negative.

    Raises:
        InvalidServiceNameException: The name is malformed.
        TypeError: The execute callback is not callable.
    """

    def __init__(
        self,
        node: NodeEndpoints,
        action_type: type[ActionType[GoalT, ResultT, FeedbackT]],
        action_name: str,
        execute_callback: ExecuteCallback[GoalT, ResultT, FeedbackT] | None = None,
        *,
        callback_group: CallbackGroup | None = None,
        goal_callback: GoalCallback[GoalT] = default_goal_callback,
        handle_accepted_callback: AcceptedCallback[
            GoalT, ResultT, FeedbackT
        ] = default_handle_accepted_callback,
        cancel_callback: CancelCallback[GoalT, ResultT, FeedbackT] = default_cancel_callback,
        goal_service_qos_profile: QoSProfile = qos_profile_services_default,
        result_service_qos_profile: QoSProfile = qos_profile_services_default,
        cancel_service_qos_profile: QoSProfile = qos_profile_services_default,
        feedback_pub_qos_profile: QoSProfile = FEEDBACK_QOS,
        status_pub_qos_profile: QoSProfile = qos_profile_action_status_default,
        result_timeout: float = _RESULT_TIMEOUT_S,
    ) -> None:
        self._node = node
        # For type checkers, an action class is an object whose attributes are classes.
        self._action_type = cast("ActionType[GoalT, ResultT, FeedbackT]", action_type)
        self._name = action_name
        self._logger = node.get_logger().get_child("action_server")
        self.lock = threading.RLock()
        self._goal_handles: dict[bytes, ServerGoalHandle[GoalT, ResultT, FeedbackT]] = {}
        self._destroyed = False
        # GID of the client whose goal the goal callback is called for (ours).
        self.goal_sender = b""
        self._execute_callback: ExecuteCallback[GoalT, ResultT, FeedbackT] | None = None
        if execute_callback is not None:
            self.register_execute_callback(execute_callback)
        elif handle_accepted_callback is default_handle_accepted_callback:
            self._logger.warning("Not handling nor executing the goal, this server will do nothing")
        self.register_goal_callback(goal_callback)
        self.register_handle_accepted_callback(handle_accepted_callback)
        self.register_cancel_callback(cancel_callback)
        group = callback_group or node.default_callback_group
        self._executions = ExecutionQueue(node)
        self._timeout_ns = from_seconds(result_timeout)
        self._expiry = node.create_timer(
            max(0.0, result_timeout), self._forget_expired, group, autostart=False
        )
        parts = self._action_type.Impl

        # Any: the services of any action.
        def serve(type_: type[Any], name: str, callback: Any, qos: QoSProfile) -> Any:
            name = node.resolve_service_name(f"{action_name}/_action/{name}")
            return node.add_endpoint(DeferringService(node, type_, name, callback, group, qos))

        self._services = (
            serve(
                parts.SendGoalService,
                "send_goal",
                self._handle_goal_request,
                goal_service_qos_profile,
            ),
            serve(parts.CancelGoalService, "cancel_goal", self._cancel, cancel_service_qos_profile),
            serve(
                parts.GetResultService, "get_result", self._send_result, result_service_qos_profile
            ),
        )
        self._feedback = node.create_publisher(
            parts.FeedbackMessage, f"{action_name}/_action/feedback", feedback_pub_qos_profile
        )
        self._status = node.create_publisher(
            parts.GoalStatusMessage, f"{action_name}/_action/status", status_pub_qos_profile
        )

    @property
    def action_type(self) -> ActionType[GoalT, ResultT, FeedbackT]:
        """Action class of the server."""
        return self._action_type

    @property
    def action_name(self) -> str:
        """Fully qualified name of the action (ours)."""
        return self._feedback.topic_name.removesuffix("/_action/feedback")

    def get_num_entities(self) -> NumberOfEntities:
        """Return the entity numbers of the action server: 1 timer and 3 services."""
        return NumberOfEntities(num_timers=1, num_services=len(self._services))

    # -- callbacks -------------------------------------------------------------------------------

    def register_goal_callback(self, goal_callback: GoalCallback[GoalT] | None) -> None:
        """Replace the callback that accepts or rejects goals; None accepts all."""
        self._goal_callback = goal_callback or default_goal_callback

    def register_handle_accepted_callback(
        self, handle_accepted_callback: AcceptedCallback[GoalT, ResultT, FeedbackT] | None
    ) -> None:
        """Replace the callback for accepted goals; None schedules each goal's execution at once."""
        self._handle_accepted_callback = (
            handle_accepted_callback or default_handle_accepted_callback
        )

    def register_cancel_callback(
        self, cancel_callback: CancelCallback[GoalT, ResultT, FeedbackT] | None
    ) -> None:
        """Replace the callback that accepts or rejects cancel requests; None rejects all."""
        self._cancel_callback = cancel_callback or default_cancel_callback

    def register_execute_callback(
        self, execute_callback: ExecuteCallback[GoalT, ResultT, FeedbackT]
    ) -> None:
        """Replace the callback that executes goals and returns their results.

        Raises:
            TypeError: The callback is not callable.
        """
        if not callable(execute_callback):
            raise TypeError("Failed to register goal execution callback: not callable")
        self._execute_callback = execute_callback

    # -- requests --------------------------------------------------------------------------------

    # Any, here and below: requests and responses of any action.

    async def _handle_goal_request(self, request: Any, reply: Callable[[Any], None]) -> None:
        key = goal_key(request.goal_id)
        response = self._action_type.Impl.SendGoalService.Response()
        handle = None
        if key in self._goal_handles:
            self._logger.debug(f"Goal {key.hex()} is already known")
        elif await self._is_accepted(request.goal, reply):
            set_stamp(response.stamp, self.now_ns())
            handle = self._add(key, request)
        response.accepted = handle is not None
        self._logger.debug(f"Goal {key.hex()} {'accepted' if handle else 'rejected'}")
        reply(response)
        if handle is not None:
            self.publish_status()
            await call_and_await(self._handle_accepted_callback, handle)

    async def _is_accepted(self, goal: GoalT, reply: Callable[[Any], None]) -> bool:
        self.goal_sender = getattr(reply, "sender", b"")
        answer = await call_and_await(self._goal_callback, goal)
        if not isinstance(answer, GoalResponse):
            self._logger.warning(
                "Goal request callback did not return a GoalResponse type. Rejecting goal."
            )
        return answer is GoalResponse.ACCEPT

    def _add(self, key: bytes, request: Any) -> ServerGoalHandle[GoalT, ResultT, FeedbackT] | None:
        """Store a new goal; return None if the server has a goal with the same id by now."""
        info = get_message("action_msgs/msg/GoalInfo")(goal_id=request.goal_id)
        with self.lock:
            if key in self._goal_handles or self._destroyed:
                return None
            handle = ServerGoalHandle(self, info, cast("GoalT", request.goal))
            self._goal_handles[key] = handle
            return handle

    async def _cancel(
        self, request: CancelGoal.Request, reply: Callable[[CancelGoal.Response], None]
    ) -> None:
        response: CancelGoal.Response = self._action_type.Impl.CancelGoalService.Response()
        info = request.goal_info
        with self.lock:
            response.return_code, meant = goals_to_cancel(
                self._goal_handles.values(), goal_key(info.goal_id), to_nanoseconds(info.stamp)
            )
        # Goals that are rejected, or end before their turn, are left out; the code stays.
        response.goals_canceling = [
            handle.goal_info
            for handle in meant
            if await call_and_await(self._cancel_callback, handle) is CancelResponse.ACCEPT
            and handle.begin_cancel()
        ]
        reply(response)

    def _send_result(self, request: Any, reply: Callable[[Any], None]) -> None:
        handle = self._goal_handles.get(goal_key(request.goal_id))
        if handle is None:
            reply(self._action_type.Impl.GetResultService.Response())
        else:
            handle.when_finished(reply)

    def active_goals(self) -> list[ServerGoalHandle[GoalT, ResultT, FeedbackT]]:
        """Return the handles of the goals that have not ended, the oldest first (ours)."""
        with self.lock:
            return [handle for handle in self._goal_handles.values() if handle.is_active]

    # -- methods for goal handles -----------------------------------------------------------------

    def now_ns(self) -> int:
        """Return the time of the node's clock in nanoseconds (ours)."""
        return self._node.get_clock().nanoseconds()

    def elapsed_ns(self) -> int:
        """Return the node clock's `elapsed_ns`, of steady or active simulated time (ours)."""
        return self._node.get_clock().elapsed_ns()

    def publish_status(self) -> None:
        """Publish the status of all goals that are still kept, the oldest first (ours)."""
        with self.lock:
            if self._destroyed:
                return
            message = self._action_type.Impl.GoalStatusMessage()
            message.status_list = [h.status_message for h in self._goal_handles.values()]
            self._status.publish(message)

    def publish_feedback(self, goal_id: UUID, feedback: FeedbackT) -> None:
        """Publish feedback for a goal, given its id; does nothing after `destroy` (ours)."""
        if not self._destroyed:
            message = self._action_type.Impl.FeedbackMessage(goal_id=goal_id, feedback=feedback)
            self._feedback.publish(message)

    def notify_execute(
        self,
        goal_handle: ServerGoalHandle[GoalT, ResultT, FeedbackT],
        execute_callback: ExecuteCallback[GoalT, ResultT, FeedbackT] | None,
    ) -> None:
        """Schedule a callback that executes a goal; the server's execute callback if None."""
        callback = execute_callback or self._execute_callback
        if callback is not None:
            self._executions.add(functools.partial(self._execute, callback, goal_handle))

    async def _execute(
        self,
        callback: ExecuteCallback[GoalT, ResultT, FeedbackT],
        goal_handle: ServerGoalHandle[GoalT, ResultT, FeedbackT],
    ) -> None:
        result = None
        try:
            result = await call_and_await(callback, goal_handle)
            goal_handle.check_result(result)
        except Exception as error:  # noqa: BLE001 (any exception aborts the goal)
            result = None
            if self._node.context.ok():
                import traceback

                self._logger.error(f"Error raised in execute callback: {error}")
                traceback.print_exc()
        if not self._node.context.ok():
            return  # no client can be reached any more
        if goal_handle.is_active:
            self._logger.warning(
                f"Goal state not set, assuming aborted. Goal ID: {goal_handle.key.hex()}"
            )
            goal_handle.abort()
        goal_handle.finish(result)

    # -- the end of goals ------------------------------------------------------------------------

    def notify_goal_done(self) -> None:
        """Start the timer that drops ended goals after the result timeout, unless it is running."""
        with self.lock:
            if self._expiry.is_canceled() and self._timeout_ns >= 0:
                self._expiry.restart(self._timeout_ns)

    def _forget_expired(self) -> None:
        with self.lock:
            now_ns = self.elapsed_ns()
            next_ns = None
            for key, handle in tuple(self._goal_handles.items()):
                if handle.ended_ns is None:
                    continue
                left_ns = handle.ended_ns + self._timeout_ns - now_ns
                if left_ns <= 0:
                    self._goal_handles.pop(key).destroy()
                else:
                    next_ns = min(left_ns, next_ns or left_ns)
            if next_ns is None:
                self._expiry.cancel()
            else:
                # The clock may have jumped back since the goal ended.
                self._expiry.restart(min(next_ns, self._timeout_ns))

    def destroy(self) -> None:
        """Drop all goals and remove the server from the graph. Idempotent."""
        with self.lock:
            if self._destroyed:
                return
            self._destroyed = True
            handles, self._goal_handles = tuple(self._goal_handles.values()), {}
        for handle in handles:
            handle.destroy()
        self._executions.destroy()
        self._node.destroy_timer(self._expiry)
        self._node.destroy_publisher(self._status)
        self._node.destroy_publisher(self._feedback)
        for service in reversed(self._services):
            self._node.destroy_service(service)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()
