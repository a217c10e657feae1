"""The buffer of transforms, with the methods of ``tf2_ros.Buffer``."""

import threading
import time as wall
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from teleopctl.interfaces import to_seconds
from teleopctl.tf.conversions import BufferInterface
from teleopctl.tf.errors import TransformException
from teleopctl.tf.history import Sample
from teleopctl.tf.messages import stamp_of, transform_of, transform_stamped
from teleopctl.tf.transforms import Transform
from teleopctl.tf.tree import FrameTree

if TYPE_CHECKING:
    from geometry_msgs.msg import TransformStamped

    from teleopctl.node import Future, Node

_DEFAULT_CACHE_NS = 10_000_000_000

_Answer = TypeVar("_Answer")


class Buffer(BufferInterface):
    """Remembers where frames stood and answers where one stands in another.

    All methods may be called from any thread. A time of 0 (``Time()``) asks for the newest time
    at which every frame between the two is known.

    Args:
        cache_time: How far back moving frames are remembered; 10 s if None.
        node: Offers the frames as the service ``tf2_frames``, for tools; none does if None. The
            transforms themselves come through a ``TransformListener``.
    """

    def __init__(self, cache_time: Any = None, node: "Node | None" = None) -> None:
        super().__init__()
        self.node = node
        self.cache_time_ns = _DEFAULT_CACHE_NS if cache_time is None else stamp_of(cache_time)
        self._tree = FrameTree(self.cache_time_ns)
        self._changed = threading.Condition()
        self._awaited: list[tuple[Callable[[], Any], Future[TransformStamped]]] = []
        self._listening: Node | None = None
        if node is not None:
            from teleopctl.interfaces import get_service

            frames = get_service("tf2_msgs/srv/FrameGraph")
            self.srv = node.create_service(frames, "tf2_frames", self._tell_frames)

    def _tell_frames(self, _request: Any, response: Any) -> Any:
        response.frame_yaml = self.all_frames_as_yaml()
        return response

    def set_transform(self, transform: Any, authority: str = "") -> bool:
        """Add a ``geometry_msgs/msg/TransformStamped`` of a moving frame.

        Returns:
            False when it was not taken: too old, known already, or not valid.
        """
        return self._set(transform, authority, static=False)

    def set_transform_static(self, transform: Any, authority: str = "") -> bool:
        """Add a ``geometry_msgs/msg/TransformStamped`` that holds for all times.

        Returns:
            False when it is not valid.
        """
        return self._set(transform, authority, static=True)

    def _set(self, message: Any, authority: str, *, static: bool) -> bool:
        header = message.header
        sample = Sample(stamp_of(header.stamp), header.frame_id, transform_of(message.transform))
        with self._changed:
            taken = self._tree.insert(sample, message.child_frame_id, authority, static=static)
            if taken:
                self._changed.notify_all()
        if self._awaited and self._listening is None:
            self.answer_awaited()
        return taken

    def clear(self) -> None:
        """Forget where moving frames stood."""
        with self._changed:
            self._tree.clear()

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: Any, timeout: Any = None
    ) -> Any:
        """Return where the source frame stands in the target frame.

        Args:
            target_frame: The frame in which the answer is expressed.
            source_frame: The frame that is looked for.
            time: When; 0 for the newest time that is known.
            timeout: A ``Duration`` to wait for it at most; None does not wait.

        Returns:
            A ``geometry_msgs/msg/TransformStamped``.

        Raises:
            LookupException: When a frame is not known.
            ConnectivityException: When no chain joins the frames.
            ExtrapolationException: When the time lies outside of what is known.
            InvalidArgumentException: When a frame's name is not allowed.
        """
        stamp, transform = self.lookup(target_frame, source_frame, stamp_of(time), timeout)
        return transform_stamped(target_frame, source_frame, stamp, transform)

    def lookup(
        self, target_frame: str, source_frame: str, stamp: int, timeout: Any = None
    ) -> tuple[int, Transform]:
        """Answer as ``lookup_transform`` does, in nanoseconds and plain numbers."""

        def answer() -> tuple[int, Transform]:
            target = self._tree.check(target_frame, "target_frame", "lookupTransform")
            source = self._tree.check(source_frame, "source_frame", "lookupTransform")
            return self._tree.lookup(target, source, stamp)

        return self._when_known(answer, timeout)

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = None,
    ) -> Any:
        """Return where the source stood at one time, in the target as it stood at another.

        Args:
            target_frame: The frame in which the answer is expressed.
            target_time: When the target is looked at.
            source_frame: The frame that is looked for.
            source_time: When the source is looked at.
            fixed_frame: The frame that does not move between the two times.
            timeout: A ``Duration`` to wait for it at most; None does not wait.

        Returns:
            A ``geometry_msgs/msg/TransformStamped``.

        Raises:
            TransformException: As ``lookup_transform`` does.
        """
        answer = self._through(
            (target_frame, stamp_of(target_time)),
            (source_frame, stamp_of(source_time)),
            fixed_frame,
            "lookupTransform",
        )
        stamp, transform = self._when_known(answer, timeout)
        return transform_stamped(target_frame, source_frame, stamp, transform)

    def wait_for_transform_async(
        self, target_frame: str, source_frame: str, time: Any
    ) -> "Future[TransformStamped]":
        """Return a future of what ``lookup_transform`` will answer."""
        return self._await(lambda: self.lookup_transform(target_frame, source_frame, time))

    async def lookup_transform_async(self, target_frame: str, source_frame: str, time: Any) -> Any:
        """Answer as ``lookup_transform`` does, as soon as there is an answer."""
        return await self.wait_for_transform_async(target_frame, source_frame, time)

    def wait_for_transform_full_async(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
    ) -> "Future[TransformStamped]":
        """Return a future of what ``lookup_transform_full`` will answer."""
        frames = (target_frame, target_time, source_frame, source_time, fixed_frame)
        return self._await(lambda: self.lookup_transform_full(*frames))

    async def lookup_transform_full_async(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
    ) -> Any:
        """Answer as ``lookup_transform_full`` does, as soon as there is an answer."""
        return await self.wait_for_transform_full_async(
            target_frame, target_time, source_frame, source_time, fixed_frame
        )

    def _await(self, answer: Callable[[], Any]) -> "Future[TransformStamped]":
        from teleopctl.node import Future

        listening = self._listening
        future: Future[TransformStamped] = Future(
            executor=None if listening is None else listening.executor
        )
        with self._changed:
            self._awaited.append((answer, future))
        self.answer_awaited()
        return future

    def answer_awaited(self) -> None:
        """End the futures whose transform has come; their callbacks run in this thread (ours)."""
        with self._changed:
            awaited, self._awaited = self._awaited, []
        for answer, future in awaited:
            if future.done():
                continue
            try:
                found = answer()
            except TransformException:
                with self._changed:
                    self._awaited.append((answer, future))
            else:
                future.set_result(found)

    def leave_answers_to(self, node: "Node") -> None:
        """Have the executor of a node call `answer_awaited`, and what waits (ours)."""
        self._listening = node

    def can_transform(
        self,
        target_frame: str,
        source_frame: str,
        time: Any,
        timeout: Any = None,
        return_debug_tuple: bool = False,
    ) -> Any:
        """Tell whether ``lookup_transform`` would answer.

        Returns:
            A bool, or (bool, why not) with ``return_debug_tuple``.
        """

        def answer() -> tuple[int, Transform]:
            target = self._tree.check(target_frame, "target_frame", "canTransform")
            source = self._tree.check(source_frame, "source_frame", "canTransform")
            return self._tree.lookup(target, source, stamp_of(time))

        return self._told(answer, timeout, return_debug_tuple)

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = None,
        return_debug_tuple: bool = False,
    ) -> Any:
        """Tell whether ``lookup_transform_full`` would answer; see there and ``can_transform``."""
        answer = self._through(
            (target_frame, stamp_of(target_time)),
            (source_frame, stamp_of(source_time)),
            fixed_frame,
            "canTransform",
        )
        return self._told(answer, timeout, return_debug_tuple)

    def get_latest_common_time(self, target_frame: str, source_frame: str) -> Any:
        """Return the newest time at which every frame between two is known, as a ``Time``.

        Raises:
            LookupException: When a frame is not known.
            ConnectivityException: When no chain joins the frames.
        """
        from teleopctl.node import ClockType, Time

        with self._changed:
            target = self._tree.check(target_frame, "target_frame", "getLatestCommonTime")
            source = self._tree.check(source_frame, "source_frame", "getLatestCommonTime")
            stamp = self._tree.latest_common_time(target, source)
        return Time(nanoseconds=stamp, clock_type=ClockType.ROS_TIME)

    def frame_names(self) -> list[str]:
        """Return the names of all frames."""
        with self._changed:
            return self._tree.frames()

    def all_frames_as_string(self) -> str:
        """Return a sentence for each frame that has a parent."""
        with self._changed:
            pairs = list(self._tree.parents())
        return "".join(f"Frame {child} exists with parent {parent}.\n" for child, parent in pairs)

    def all_frames_as_yaml(self) -> str:
        """Return the frames and what is known of each, as YAML that tf2's tools read."""
        with self._changed:
            lines = []
            for child, parent in self._tree.parents():
                stamp, is_static = self._tree.span(child) or (0, True)
                lines.append(
                    f"{child}: \n  parent: '{parent}'\n"
                    f"  broadcaster: '{self._tree.authority(child) or 'default_authority'}'\n"
                    f"  most_recent_transform: {to_seconds(stamp):.6f}\n"
                    f"  is_static: {str(is_static).lower()}\n"
                )
        return "".join(lines) or "[]"

    def _through(
        self, target: tuple[str, int], source: tuple[str, int], fixed_frame: str, caller: str
    ) -> Callable[[], tuple[int, Transform]]:
        """Return the question where one frame at one time stood in another at another time."""
        check = self._tree.check

        def answer() -> tuple[int, Transform]:
            return self._tree.lookup_through(
                check(target[0], "target_frame", caller),
                target[1],
                check(source[0], "source_frame", caller),
                source[1],
                check(fixed_frame, "fixed_frame", caller),
            )

        return answer

    def _told(
        self, answer: Callable[[], object], timeout: Any, return_debug_tuple: bool
    ) -> bool | tuple[bool, str]:
        try:
            self._when_known(answer, timeout)
        except TransformException as error:
            return (False, error.message) if return_debug_tuple else False
        return (True, "") if return_debug_tuple else True

    def _when_known(self, answer: Callable[[], _Answer], timeout: Any) -> _Answer:
        """Return an answer as soon as there is one, within a timeout.

        The time is the wall's: simulated time may stand still, a caller should not.
        """
        left = 0.0 if timeout is None else to_seconds(stamp_of(timeout))
        deadline = wall.monotonic() + left
        with self._changed:
            while True:
                try:
                    return answer()
                except TransformException:
                    left = deadline - wall.monotonic()
                    if left <= 0:
                        raise
                self._changed.wait(left)
