"""Buffer of transforms that can wait for a transform, with the methods of ``tf2_ros.Buffer``."""

from __future__ import annotations

import logging
import threading
import time as wall
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar, cast

from teleopctl.interfaces import to_seconds
from teleopctl.tf.buffer_core import BufferCore
from teleopctl.tf.conversions import BufferInterface
from teleopctl.tf.errors import TransformException
from teleopctl.tf.messages import TimeLike, stamp_of, transform_stamped
from teleopctl.tf.transforms import Transform

if TYPE_CHECKING:
    from geometry_msgs.msg import TransformStamped

    from teleopctl.node import Clock, Future, JumpHandle, Node, TimeJump

_log = logging.getLogger(__name__)

# As in tf2_ros, a step back of the clock by 1 s or more means a new run of the simulation.
_BACK_S = -1

_Found = TypeVar("_Found")


class Buffer(BufferCore, BufferInterface):
    """Buffer of transforms over time whose lookups can wait, as in tf2_ros.

    All methods may be called from any thread. A time of 0 (``Time()``) selects the newest time
    at which every frame between the two is known. When the simulated time of the node jumps back,
    moving frames are dropped.

    Args:
        cache_time: Duration for which transforms of moving frames are kept; 10 s if None.
        node: Node that provides the service ``tf2_frames``, for tools; no service if None. The
            transforms themselves are added by a ``TransformListener``.
    """

    def __init__(self, cache_time: TimeLike | None = None, node: Node | None = None) -> None:
        BufferInterface.__init__(self)
        BufferCore.__init__(self, cache_time)
        self.node = node
        self._awaited: list[tuple[Callable[[], TransformStamped], Future[TransformStamped]]] = []
        # One thread at a time: a transform that arrives while another thread looks up must not miss
        # the futures that this thread puts back.
        self._completing = threading.Lock()
        self._executor_node: Node | None = None
        self.jump_handle: JumpHandle | None = None
        if node is not None:
            from teleopctl.interfaces import get_service

            frames = get_service("tf2_msgs/srv/FrameGraph")
            self.srv = node.create_service(frames, "tf2_frames", self._handle_frame_graph)
            self._follow(node.get_clock())

    def _handle_frame_graph(self, _request: Any, response: Any) -> Any:
        response.frame_yaml = self.all_frames_as_yaml()
        return response

    def _follow(self, clock: Clock) -> None:
        from teleopctl.node import Duration, JumpThreshold

        threshold = JumpThreshold(min_forward=None, min_backward=Duration(seconds=_BACK_S))
        self.jump_handle = clock.create_jump_callback(
            threshold, post_callback=self.time_jump_callback
        )

    def time_jump_callback(self, time_jump: TimeJump) -> None:
        """Clear moving frames, with a warning, when the clock jumped back or its source changed."""
        went_back = time_jump.delta.nanoseconds < 0
        _log.warning(
            "Detected %s. Clearing TF buffer.",
            "jump back in time" if went_back else "time source change",
        )
        self.clear()

    def _set(self, message: TransformStamped, authority: str, *, static: bool) -> None:
        super()._set(message, authority, static=static)
        if self._executor_node is None and (self._awaited or self._completing.locked()):
            self.complete_futures()

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: TimeLike, timeout: TimeLike | None = None
    ) -> TransformStamped:
        """Return a ``TransformStamped`` from source to target; wait up to ``timeout``, then raise.

        Args:
            target_frame: Frame in which the result is expressed.
            source_frame: Frame whose pose is looked up.
            time: Time of the transform; 0 for the newest time that is known.
            timeout: Longest ``Duration`` to wait for the transform; None does not wait.

        Returns:
            A ``geometry_msgs/msg/TransformStamped``.

        Raises:
            LookupException: A frame is not known.
            ConnectivityException: The frames are not connected.
            ExtrapolationException: The time lies outside of the buffered transforms.
            InvalidArgumentException: The name of a frame is invalid.
        """
        stamp, transform = self.lookup(target_frame, source_frame, stamp_of(time), timeout)
        return transform_stamped(target_frame, source_frame, stamp, transform)

    def lookup(
        self, target_frame: str, source_frame: str, stamp: int, timeout: TimeLike | None = None
    ) -> tuple[int, Transform]:
        """Return (stamp in ns, `Transform`), waiting as `lookup_transform` does (not in tf2)."""
        lookup = self._between(target_frame, source_frame, stamp, "lookupTransform")
        return self._when_known(lookup, timeout)

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: TimeLike,
        source_frame: str,
        source_time: TimeLike,
        fixed_frame: str,
        timeout: TimeLike | None = None,
    ) -> TransformStamped:
        """Return the transform from source at one time to target at another, via a fixed frame.

        Args:
            target_frame: Frame in which the result is expressed.
            target_time: Time of the target frame.
            source_frame: Frame whose pose is looked up.
            source_time: Time of the source frame.
            fixed_frame: Frame that does not move between the two times.
            timeout: Longest ``Duration`` to wait for the transform; None does not wait.

        Returns:
            A ``geometry_msgs/msg/TransformStamped``.

        Raises:
            TransformException: As ``lookup_transform`` does.
        """
        frames = (target_frame, target_time, source_frame, source_time, fixed_frame)
        lookup = self._through(*frames, "lookupTransform")
        stamp, transform = self._when_known(lookup, timeout)
        return transform_stamped(target_frame, source_frame, stamp, transform)

    def wait_for_transform_async(
        self, target_frame: str, source_frame: str, time: TimeLike
    ) -> Future[TransformStamped]:
        """Return a future of the ``TransformStamped``, pending until the lookup succeeds."""
        return self._await(lambda: self.lookup_transform(target_frame, source_frame, time))

    async def lookup_transform_async(
        self, target_frame: str, source_frame: str, time: TimeLike
    ) -> TransformStamped:
        """Return the ``TransformStamped`` once the lookup succeeds, however long that takes."""
        found = await self.wait_for_transform_async(target_frame, source_frame, time)
        return cast("TransformStamped", found)

    def wait_for_transform_full_async(
        self,
        target_frame: str,
        target_time: TimeLike,
        source_frame: str,
        source_time: TimeLike,
        fixed_frame: str,
    ) -> Future[TransformStamped]:
        """Return a future of ``lookup_transform_full``'s result, pending until it succeeds."""
        frames = (target_frame, target_time, source_frame, source_time, fixed_frame)
        return self._await(lambda: self.lookup_transform_full(*frames))

    async def lookup_transform_full_async(
        self,
        target_frame: str,
        target_time: TimeLike,
        source_frame: str,
        source_time: TimeLike,
        fixed_frame: str,
    ) -> TransformStamped:
        """Return ``lookup_transform_full``'s result once that lookup succeeds, without limit."""
        frames = (target_frame, target_time, source_frame, source_time, fixed_frame)
        return cast("TransformStamped", await self.wait_for_transform_full_async(*frames))

    def _await(self, lookup: Callable[[], TransformStamped]) -> Future[TransformStamped]:
        from teleopctl.node import Future

        node = self._executor_node
        future: Future[TransformStamped] = Future(executor=None if node is None else node.executor)
        with self._changed:
            self._awaited.append((lookup, future))
        self.complete_futures()
        return future

    def complete_futures(self) -> None:
        """Complete, in this thread, the pending futures whose lookups now succeed (not in tf2)."""
        found: list[tuple[Future[TransformStamped], TransformStamped]] = []
        with self._completing:
            with self._changed:
                awaited, self._awaited = self._awaited, []
            for lookup, future in awaited:
                if future.ended():
                    continue
                try:
                    found.append((future, lookup()))
                except TransformException:
                    with self._changed:
                        self._awaited.append((lookup, future))
        for future, transform in found:
            future.set_result(transform)

    def use_executor_of(self, node: Node) -> None:
        """Leave completing futures to a node's executor, and clear when its clock jumps back."""
        self._executor_node = node
        if self.jump_handle is None:
            self._follow(node.get_clock())

    # Any, here and below: a bool, or a pair with return_debug_tuple.
    def can_transform(
        self,
        target_frame: str,
        source_frame: str,
        time: TimeLike,
        timeout: TimeLike | None = None,
        return_debug_tuple: bool = False,
    ) -> Any:
        """Return whether `lookup_transform` succeeds in time; as debug tuple with the reason.

        Returns:
            A bool, or (bool, reason of a failure) with ``return_debug_tuple``.
        """
        lookup = self._between(target_frame, source_frame, stamp_of(time), "canTransform")
        return self._known_in_time(lookup, timeout, return_debug_tuple)

    def can_transform_full(
        self,
        target_frame: str,
        target_time: TimeLike,
        source_frame: str,
        source_time: TimeLike,
        fixed_frame: str,
        timeout: TimeLike | None = None,
        return_debug_tuple: bool = False,
    ) -> Any:
        """Return whether `lookup_transform_full` succeeds; as debug tuple with the reason."""
        frames = (target_frame, target_time, source_frame, source_time, fixed_frame)
        lookup = self._through(*frames, "canTransform")
        return self._known_in_time(lookup, timeout, return_debug_tuple)

    def _known_in_time(
        self, lookup: Callable[[], object], timeout: TimeLike | None, return_debug_tuple: bool
    ) -> bool | tuple[bool, str]:
        try:
            self._when_known(lookup, timeout)
        except TransformException as error:
            return (False, error.message) if return_debug_tuple else False
        return (True, "") if return_debug_tuple else True

    def _when_known(self, lookup: Callable[[], _Found], timeout: TimeLike | None) -> _Found:
        """Return an answer as soon as there is one, within a timeout.

        The timeout is in wall time, so that it also ends while simulated time stands still.
        """
        left = 0.0 if timeout is None else to_seconds(stamp_of(timeout))
        deadline = wall.monotonic() + left
        with self._changed:
            while True:
                try:
                    return lookup()
                except TransformException:
                    left = deadline - wall.monotonic()
                    if left <= 0:
                        raise
                self._changed.wait(left)
