"""Client of a transform buffer in another process, as ``tf2_ros.BufferClient``."""

from __future__ import annotations

import time as wall
from typing import TYPE_CHECKING, Any, TypeVar

from teleopctl.interfaces import get_action, set_stamp
from teleopctl.tf.conversions import BufferInterface
from teleopctl.tf.errors import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)
from teleopctl.tf.messages import TimeLike, stamp_of

if TYPE_CHECKING:
    from geometry_msgs.msg import TransformStamped

    from teleopctl.node import Node, ResponseFuture

_Result = TypeVar("_Result")

# Keys: error codes of tf2_msgs/msg/TF2Error. Other codes raise a TransformException.
_ERRORS: dict[int, type[TransformException]] = {
    1: LookupException,
    2: ConnectivityException,
    3: ExtrapolationException,
    4: InvalidArgumentException,
    5: TimeoutException,
}
_PADDING_S = 2.0


class BufferClient(BufferInterface):
    """Client of a buffer server, for lookups by the action ``tf2_msgs/action/LookupTransform``.

    Calls block their thread, and need no executor to return.

    Args:
        node: Node of the action client.
        ns: Name of the server's action.
        check_frequency: Unused. tf2_ros polls for the result at this rate in Hz; this client waits
            for an event.
        timeout_padding: Time to wait for the server in addition to a timeout; 2 s if None.
    """

    def __init__(
        self,
        node: Node,
        ns: str,
        check_frequency: float = 10.0,
        timeout_padding: TimeLike | None = None,
    ) -> None:
        from teleopctl.node import ActionClient, Duration

        super().__init__()
        self.node = node
        self.check_frequency = check_frequency
        self.timeout_padding = timeout_padding or Duration(seconds=_PADDING_S)
        # Any: the types of an action that is loaded by name.
        self.action_client: ActionClient[Any, Any, Any] = ActionClient(
            node, get_action("tf2_msgs/action/LookupTransform"), ns
        )

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: TimeLike, timeout: TimeLike | None = None
    ) -> TransformStamped:
        """Return a ``TransformStamped`` looked up by the buffer server; block until it responds.

        Raises:
            TimeoutException: There is no server, or the server does not respond in time.
            TransformException: The lookup in the server's buffer failed.
        """
        goal = self._goal(target_frame, source_frame, time, timeout)
        return self._request(goal, stamp_of(timeout or 0))

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: TimeLike,
        source_frame: str,
        source_time: TimeLike,
        fixed_frame: str,
        timeout: TimeLike | None = None,
    ) -> TransformStamped:
        """Return the transform between two frames at two times from the buffer server; block."""
        goal = self._goal(target_frame, source_frame, source_time, timeout)
        set_stamp(goal.target_time, stamp_of(target_time))
        goal.fixed_frame = fixed_frame
        goal.advanced = True
        return self._request(goal, stamp_of(timeout or 0))

    def can_transform(
        self, target_frame: str, source_frame: str, time: TimeLike, timeout: TimeLike | None = None
    ) -> bool:
        """Return whether the server's lookup succeeds in time; False also without a server."""
        try:
            self.lookup_transform(target_frame, source_frame, time, timeout)
        except TransformException:
            return False
        return True

    def can_transform_full(
        self,
        target_frame: str,
        target_time: TimeLike,
        source_frame: str,
        source_time: TimeLike,
        fixed_frame: str,
        timeout: TimeLike | None = None,
    ) -> bool:
        """Return whether the server's lookup at two times succeeds; False also without a server."""
        frames = (target_frame, target_time, source_frame, source_time, fixed_frame)
        try:
            self.lookup_transform_full(*frames, timeout)
        except TransformException:
            return False
        return True

    def destroy(self) -> None:
        """Destroy the action client. Idempotent."""
        self.action_client.destroy()

    # Any, here and below: a goal and a result of the action.
    def _goal(
        self, target_frame: str, source_frame: str, time: TimeLike, timeout: TimeLike | None
    ) -> Any:
        goal = get_action("tf2_msgs/action/LookupTransform").Goal(
            target_frame=target_frame, source_frame=source_frame
        )
        set_stamp(goal.source_time, stamp_of(time))
        set_stamp(goal.timeout, stamp_of(timeout or 0))
        return goal

    def _request(self, goal: Any, timeout_ns: int) -> TransformStamped:
        if not self.action_client.server_is_ready():
            name = self.action_client.action_name
            raise TimeoutException(f"No buffer server answers at {name}.")
        deadline = wall.monotonic() + (timeout_ns + stamp_of(self.timeout_padding)) / 1e9
        handle = self._wait(self.action_client.send_goal_async(goal), deadline)
        if not handle.accepted:
            raise TimeoutException("The buffer server rejected the goal.")
        result = self._wait(handle.get_result_async(), deadline).result
        if result.error.error != result.error.NO_ERROR:
            kind = _ERRORS.get(result.error.error, TransformException)
            raise kind(result.error.error_string)
        found: TransformStamped = result.transform
        return found

    def _wait(self, future: ResponseFuture[_Result], deadline: float) -> _Result:
        future.wait_until_settled(max(0.0, deadline - wall.monotonic()))
        if not future.done():
            raise TimeoutException("The buffer server did not respond in time.")
        found = future.result()
        if found is None:
            raise TimeoutException("The buffer server has disappeared.")
        return found
