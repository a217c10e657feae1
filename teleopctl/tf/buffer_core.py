"""Buffer of transforms without node and without waiting, with the methods of ``tf2_py``."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from teleopctl.tf import frame_texts
from teleopctl.tf.errors import TransformException
from teleopctl.tf.history import TransformSample
from teleopctl.tf.messages import TimeLike, stamp_of, transform_of, transform_stamped
from teleopctl.tf.transforms import Transform, Vector3
from teleopctl.tf.tree import FrameTree
from teleopctl.tf.velocity import velocity

if TYPE_CHECKING:
    from geometry_msgs.msg import TransformStamped

    from teleopctl.node import Time

_DEFAULT_CACHE_NS = 10_000_000_000

Lookup = Callable[[], tuple[int, Transform]]


class BufferCore:
    """Buffer of transforms over time, as in tf2_py: no ROS communication, no waiting lookups.

    All methods may be called from any thread. A time of 0 (``Time()``) selects the newest time
    at which every frame between the two is known.

    Args:
        cache_time: ``Duration`` for which transforms of moving frames are kept; 10 s if None.
    """

    def __init__(self, cache_time: TimeLike | None = None) -> None:
        self.cache_time_ns = _DEFAULT_CACHE_NS if cache_time is None else stamp_of(cache_time)
        self._tree = FrameTree(self.cache_time_ns)
        self._changed = threading.Condition()

    # -- transforms ------------------------------------------------------------------------------

    def set_transform(self, transform: TransformStamped, authority: str = "") -> None:
        """Add a ``TransformStamped`` of a moving frame; an invalid or too old one is only logged.

        A transform replaces an earlier one with the same stamp. Invalid transforms, and transforms
        older than the cache time, are logged and ignored.
        """
        self._set(transform, authority, static=False)

    def set_transform_static(self, transform: TransformStamped, authority: str = "") -> None:
        """Add a ``TransformStamped`` valid for all times; it replaces earlier ones of the child."""
        self._set(transform, authority, static=True)

    def _set(self, message: TransformStamped, authority: str, *, static: bool) -> None:
        header = message.header
        sample = TransformSample(
            stamp_of(header.stamp), header.frame_id, transform_of(message.transform)
        )
        with self._changed:
            if self._tree.insert(sample, message.child_frame_id, authority, static=static):
                self._changed.notify_all()

    def clear(self) -> None:
        """Drop the transforms of moving frames; static ones and all frame names stay."""
        with self._changed:
            self._tree.clear()

    def forget(self, frames: Iterable[str]) -> None:
        """Remove these frames' transforms, and names that are no parent either (not in tf2)."""
        with self._changed:
            self._tree.forget(frames)

    def latest(self) -> list[tuple[str, TransformSample]]:
        """Return (frame, newest `TransformSample`) per frame that has a parent (not in tf2)."""
        with self._changed:
            return self._tree.latest()

    # -- lookups ---------------------------------------------------------------------------------

    def lookup_transform_core(
        self, target_frame: str, source_frame: str, time: TimeLike
    ) -> TransformStamped:
        """Return the ``TransformStamped`` from source to target frame, or raise at once."""
        lookup = self._between(target_frame, source_frame, stamp_of(time), "lookupTransform")
        with self._changed:
            stamp, transform = lookup()
        return transform_stamped(target_frame, source_frame, stamp, transform)

    def lookup_transform_full_core(
        self,
        target_frame: str,
        target_time: TimeLike,
        source_frame: str,
        source_time: TimeLike,
        fixed_frame: str,
    ) -> TransformStamped:
        """Return the transform from source at one time to target at another, or raise at once."""
        frames = (target_frame, target_time, source_frame, source_time, fixed_frame)
        lookup = self._through(*frames, "lookupTransform")
        with self._changed:
            stamp, transform = lookup()
        return transform_stamped(target_frame, source_frame, stamp, transform)

    def can_transform_core(
        self, target_frame: str, source_frame: str, time: TimeLike
    ) -> tuple[bool, str]:
        """Return whether `lookup_transform_core` succeeds, and the reason if not."""
        return self._availability(
            self._between(target_frame, source_frame, stamp_of(time), "canTransform")
        )

    def can_transform_full_core(
        self,
        target_frame: str,
        target_time: TimeLike,
        source_frame: str,
        source_time: TimeLike,
        fixed_frame: str,
    ) -> tuple[bool, str]:
        """Return whether `lookup_transform_full_core` succeeds, and the reason if not."""
        frames = (target_frame, target_time, source_frame, source_time, fixed_frame)
        return self._availability(self._through(*frames, "canTransform"))

    def get_latest_common_time(self, target_frame: str, source_frame: str) -> Time:
        """Return the newest ``Time`` at which two frames' transform is known; 0 if it is static.

        Raises:
            LookupException: A frame is not known.
            ConnectivityException: The frames are not connected.
        """
        from teleopctl.node import Time

        with self._changed:
            target = self._tree.check(target_frame, "target_frame", "getLatestCommonTime")
            source = self._tree.check(source_frame, "source_frame", "getLatestCommonTime")
            stamp = self._tree.latest_common_time(target, source)
        # A time of the system clock, as in tf2_py.
        return Time(nanoseconds=stamp)

    def lookupVelocityCore(  # noqa: N802 -- tf2's name
        self,
        tracking_frame: str,
        observation_frame: str,
        time: TimeLike,
        averaging_interval: TimeLike,
    ) -> tuple[Vector3, Vector3]:
        """Return linear, angular velocity of a frame in another, averaged over an interval.

        Args:
            tracking_frame: Moving frame.
            observation_frame: Frame relative to which the movement is measured.
            time: Middle of the averaging interval.
            averaging_interval: ``Duration`` over which the movement is averaged.

        Returns:
            Linear velocity of the frame's origin in m/s, and angular velocity in rad/s.

        Raises:
            TransformException: As `Buffer.lookup_transform` does.
        """
        frames = (tracking_frame, observation_frame, observation_frame, tracking_frame)
        with self._changed:
            return velocity(
                self._tree, *frames, (0.0, 0.0, 0.0), stamp_of(time), stamp_of(averaging_interval)
            )

    def lookupVelocityFullCore(  # noqa: N802 -- tf2's name
        self,
        tracking_frame: str,
        observation_frame: str,
        reference_frame: str,
        reference_point: Vector3,
        reference_point_frame: str,
        time: TimeLike,
        averaging_interval: TimeLike,
    ) -> tuple[Vector3, Vector3]:
        """Return linear, angular velocity of a point fixed in a frame; see `lookupVelocityCore`.

        Args:
            tracking_frame: Moving frame.
            observation_frame: Frame relative to which the movement is measured.
            reference_frame: Frame in which the result is expressed.
            reference_point: Point whose velocity is computed, in metres.
            reference_point_frame: Frame in which the point is given.
            time: Middle of the averaging interval.
            averaging_interval: ``Duration`` over which the movement is averaged.
        """
        frames = (tracking_frame, observation_frame, reference_frame, reference_point_frame)
        when, interval = stamp_of(time), stamp_of(averaging_interval)
        with self._changed:
            return velocity(self._tree, *frames, reference_point, when, interval)

    # -- the frames ------------------------------------------------------------------------------

    def frame_names(self) -> list[str]:
        """Return the names of all frames."""
        with self._changed:
            return self._tree.frames()

    def _frameExists(self, frame_id: str) -> bool:  # noqa: N802 -- tf2's name
        return frame_id in self.frame_names()

    def _getFrameStrings(self) -> list[str]:  # noqa: N802 -- tf2's name
        return self.frame_names()

    def all_frames_as_string(self) -> str:
        """Return a text: a line ``Frame A exists with parent B.`` for each frame with a parent."""
        with self._changed:
            return frame_texts.as_string(self._tree)

    def all_frames_as_yaml(self) -> str:
        """Return YAML text of the frames with a parent: broadcaster, rate, time span, as in tf2."""
        with self._changed:
            return frame_texts.as_yaml(self._tree)

    def _allFramesAsDot(self, time: TimeLike | None = None) -> str:  # noqa: N802 -- tf2's name
        """Return the frames as a graph for Graphviz, with their ages at a time if one is given."""
        with self._changed:
            return frame_texts.as_dot(self._tree, 0 if time is None else stamp_of(time))

    def all_frames_as_dot(self, now_ns: int) -> str:
        """Return a Graphviz graph of the frames as text, with ages at ``now_ns`` (not in tf2)."""
        with self._changed:
            return frame_texts.as_dot(self._tree, now_ns)

    def known_frames(self) -> list[frame_texts.KnownFrame]:
        """Return a `KnownFrame` (publisher, rate, times) per frame with a parent (not in tf2)."""
        with self._changed:
            return frame_texts.known_frames(self._tree)

    def _chain(
        self,
        target_frame: str,
        target_time: TimeLike,
        source_frame: str,
        source_time: TimeLike,
        fixed_frame: str,
    ) -> list[str]:
        """Return the frames on the way from the source frame to the fixed frame, both included.

        If the two times differ, the path continues to the target frame, as in tf2.

        Raises:
            TransformException: A frame is not known, or the frames are not connected at their time.
        """
        with self._changed:
            for frame, argument in (
                (source_frame, "source_frame"),
                (fixed_frame, "fixed_frame"),
                (target_frame, "target_frame"),
            ):
                self._tree.check(frame, argument, "_chain")
            chain = self._tree.chain(fixed_frame, source_frame, stamp_of(source_time))
            if stamp_of(source_time) != stamp_of(target_time):
                chain += self._tree.chain(target_frame, fixed_frame, stamp_of(target_time))[1:]
            return chain

    # -- inside ----------------------------------------------------------------------------------

    def _between(self, target_frame: str, source_frame: str, stamp: int, caller: str) -> Lookup:
        """Return a function that looks up the transform between two frames."""

        def look_up() -> tuple[int, Transform]:
            # As in tf2, the transform of a frame to itself is the identity even if it is unknown.
            if target_frame != source_frame:
                self._tree.check(target_frame, "target_frame", caller)
                self._tree.check(source_frame, "source_frame", caller)
            return self._tree.lookup(target_frame, source_frame, stamp)

        return look_up

    def _through(
        self,
        target_frame: str,
        target_time: TimeLike,
        source_frame: str,
        source_time: TimeLike,
        fixed_frame: str,
        caller: str,
    ) -> Lookup:
        """Return a function that looks up the transform between two frames at two times."""
        check = self._tree.check
        target_stamp, source_stamp = stamp_of(target_time), stamp_of(source_time)

        def look_up() -> tuple[int, Transform]:
            return self._tree.lookup_through(
                check(target_frame, "target_frame", caller),
                target_stamp,
                check(source_frame, "source_frame", caller),
                source_stamp,
                check(fixed_frame, "fixed_frame", caller),
            )

        return look_up

    def _availability(self, lookup: Lookup) -> tuple[bool, str]:
        try:
            with self._changed:
                lookup()
        except TransformException as error:
            return False, error.message
        return True, ""
