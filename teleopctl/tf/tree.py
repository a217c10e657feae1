"""Tree of frames over time, without messages, nodes or clocks.

Times are integers in nanoseconds; 0 selects the newest time at which all frames are known.
"""

import logging
import math
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from teleopctl.tf.errors import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
)
from teleopctl.tf.history import MovingHistory, StaticHistory, TransformSample, seconds
from teleopctl.tf.transforms import IDENTITY, Transform, normalize

_log = logging.getLogger(__name__)

# Largest deviation of the squared length of a quaternion from 1.
_QUATERNION_TOLERANCE = 1e-2
# Longer chains than this are taken to contain a loop.
_MAX_DEPTH = 1000
# Seconds between two warnings about the same frame.
_WARN_EVERY_S = 1.0
_LOOP = "The tf tree is invalid because it contains a loop."


class FrameTree:
    """Tree of frames with the transform history of each; not thread-safe: the owner locks.

    Args:
        length: Time before the newest sample of a frame for which samples are kept, in nanoseconds.
    """

    def __init__(self, length: int) -> None:
        self._length = length
        self._histories: dict[str, MovingHistory | StaticHistory] = {}
        self._frames: dict[str, str] = {}
        self._warned: dict[str, float] = {}

    def clear(self) -> None:
        """Drop the transforms of moving frames; static ones and names remain."""
        self._histories = {
            name: history for name, history in self._histories.items() if history.is_static
        }

    def forget(self, names: Iterable[str]) -> None:
        """Remove these frames' transforms, and names that are then no parent either."""
        for name in names:
            self._histories.pop(name, None)
            self._warned.pop(name, None)
        parents = {history.latest.parent for history in self._histories.values()}
        self._frames = {
            name: authority
            for name, authority in self._frames.items()
            if name in self._histories or name in parents
        }

    def insert(self, sample: TransformSample, child: str, authority: str, *, static: bool) -> bool:
        """Add a transform of a child frame; return False, and log, if it is invalid or too old.

        Args:
            sample: Time, parent and transform of the child frame.
            child: Name of the child frame.
            authority: Name of the transform's publisher.
            static: Whether the transform is valid for all times.

        Returns:
            False if the transform was ignored because it is older than the kept samples or
            invalid. Both are logged, old ones at most once a second per frame.
        """
        parent, child = sample.parent.removeprefix("/"), child.removeprefix("/")
        fault = _fault(sample.transform, parent, child, authority)
        if fault:
            _log.error("%s", fault)
            return False
        rotation = normalize(sample.transform.rotation)
        sample = TransformSample(
            sample.stamp, parent, Transform(sample.transform.translation, rotation)
        )
        history = self._histories.get(child)
        if history is None or history.is_static != static:
            history = StaticHistory(sample) if static else MovingHistory(self._length)
            self._histories[child] = history
        if not history.insert(sample):
            self._warn_of_old_data(child, sample.stamp, authority)
            return False
        self._frames[child] = authority
        self._frames.setdefault(parent, "")
        return True

    def __len__(self) -> int:
        """Return the number of known frames."""
        return len(self._frames)

    def frames(self) -> list[str]:
        """Return the names of all frames."""
        return list(self._frames)

    def parents(self) -> Iterator[tuple[str, str]]:
        """Yield (frame, present parent) for each frame that has a parent."""
        for child, history in self._histories.items():
            yield child, history.latest.parent

    def latest(self) -> list[tuple[str, TransformSample]]:
        """Return (frame, newest `TransformSample`) for each frame that has a parent."""
        return [(child, history.latest) for child, history in self._histories.items()]

    def authority(self, frame: str) -> str:
        """Return the publisher of a frame's last added transform; an empty string if unknown."""
        return self._frames.get(frame, "")

    def newest_stamp(self, frame: str) -> tuple[int, bool] | None:
        """Return (stamp of a frame's newest transform, whether static); None without parent."""
        history = self._histories.get(frame)
        return None if history is None else (history.latest.stamp, history.is_static)

    def stamps(self, frame: str) -> list[int]:
        """Return the stamps of a frame's transforms, oldest first; empty if static or unknown."""
        history = self._histories.get(frame)
        return [] if history is None else history.stamps

    def check(self, frame: str, argument: str, caller: str) -> str:
        """Return a frame's name unchanged, or raise if it is invalid or unknown.

        Raises:
            InvalidArgumentException: The name is empty or starts with a slash.
            LookupException: No transform names the frame.
        """
        if not frame:
            raise InvalidArgumentException(
                f"Invalid argument passed to {caller} argument {argument} "
                "in tf2 frame_ids cannot be empty"
            )
        if frame.startswith("/"):
            raise InvalidArgumentException(
                f'Invalid argument "{frame}" passed to {caller} argument {argument} '
                "in tf2 frame_ids cannot start with a '/'"
            )
        if frame not in self._frames:
            if caller == "canTransform":
                raise LookupException(
                    f'Invalid frame ID "{frame}" passed to canTransform argument {argument} '
                    "- frame does not exist"
                )
            raise LookupException(
                f'"{frame}" passed to {caller} argument {argument} does not exist. '
            )
        return frame

    def lookup(self, target: str, source: str, stamp: int) -> tuple[int, Transform]:
        """Return (stamp, transform) from the source frame to the target frame at a time, or raise.

        Args:
            target: Frame in which the result is expressed.
            source: Frame whose pose is looked up.
            stamp: Time of the transform; 0 for the newest time common to all frames between.

        Returns:
            The time of the transform (0 if all frames between are static) and the transform.

        Raises:
            ConnectivityException: The frames are not connected.
            ExtrapolationException: A frame between is not known at that time.
        """
        if target == source:
            newest = self.newest_stamp(target)
            return (stamp or (newest[0] if newest and not newest[1] else 0)), IDENTITY
        if stamp == 0:
            stamp = self.latest_common_time(target, source)
        above_source, above_target, shared = self._meet(target, source, stamp)
        return stamp, above_target[shared].inverse() @ above_source[shared]

    def chain(self, target: str, source: str, stamp: int) -> list[str]:
        """Return the frames on the path from source to target at a time, both included.

        See `lookup` for the arguments and errors.
        """
        if target == source:
            return [source]
        if stamp == 0:
            stamp = self.latest_common_time(target, source)
        above_source, above_target, shared = self._meet(target, source, stamp)
        up, down = list(above_source), list(above_target)
        return up[: up.index(shared) + 1] + down[: down.index(shared)][::-1]

    def _meet(self, target: str, source: str, stamp: int) -> "tuple[_Above, _Above, str]":
        """Return the ancestors of source and target at a time, and their first common one."""
        above_source, above_target = self._climb(source, stamp), self._climb(target, stamp)
        for frame in above_target.frames:
            if frame in above_source.frames:
                return above_source.frames, above_target.frames, frame
        # a chain may have ended early because an ancestor is not known at that time
        fault = above_source.fault or above_target.fault
        if fault is None:
            raise _not_connected(target, source)
        raise ExtrapolationException(
            f"{fault.message}, when looking up transform from frame [{source}] to frame [{target}]"
        )

    def lookup_through(
        self, target: str, target_stamp: int, source: str, source_stamp: int, fixed: str
    ) -> tuple[int, Transform]:
        """Return (stamp, transform) from source at one time to target at another, by a fixed frame.

        Args:
            target: Frame in which the result is expressed.
            target_stamp: Time of the target frame.
            source: Frame whose pose is looked up.
            source_stamp: Time of the source frame.
            fixed: Frame that does not move between the two times.

        Raises:
            ConnectivityException: The frames are not connected.
            ExtrapolationException: A frame between is not known at its time.
        """
        _, in_fixed = self.lookup(fixed, source, source_stamp)
        stamp, fixed_in_target = self.lookup(target, fixed, target_stamp)
        return stamp, fixed_in_target @ in_fixed

    def latest_common_time(self, target: str, source: str) -> int:
        """Return the newest time common to all frames between two; 0 if all are static.

        Raises:
            ConnectivityException: The frames are not connected.
        """
        source_chain = self._ancestors(source)
        target_chain = self._ancestors(target)
        if source_chain[-1] != target_chain[-1]:
            raise _not_connected(target, source)
        shared = set(source_chain) & set(target_chain)
        moving = [
            newest[0]
            for chain in (source_chain, target_chain)
            for frame in chain
            if frame not in shared and (newest := self.newest_stamp(frame)) and not newest[1]
        ]
        return min(moving, default=0)

    def _warn_of_old_data(self, child: str, stamp: int, authority: str) -> None:
        now = time.monotonic()
        if now - self._warned.get(child, -_WARN_EVERY_S) >= _WARN_EVERY_S:
            self._warned[child] = now
            _log.warning(
                "TF_OLD_DATA ignoring data from the past for frame %s at time %s according to "
                "authority %s",
                child,
                seconds(stamp),
                authority,
            )

    def _ancestors(self, frame: str) -> list[str]:
        """Return a frame and its present ancestors, up to the root."""
        chain = [frame]
        while (history := self._histories.get(chain[-1])) is not None:
            chain.append(history.latest.parent)
            if len(chain) > _MAX_DEPTH:
                raise LookupException(_LOOP)
        return chain

    def _climb(self, frame: str, stamp: int) -> "_Chain":
        """Return the transforms of a frame to itself and to each ancestor at a time."""
        transform = IDENTITY
        found = {frame: transform}
        while (history := self._histories.get(frame)) is not None:
            try:
                sample = history.at(stamp)
            except ExtrapolationException as error:
                return _Chain(found, error)
            transform = sample.transform @ transform
            frame = sample.parent
            if frame in found:
                raise LookupException(_LOOP)
            found[frame] = transform
        return _Chain(found, None)


_Above = dict[str, Transform]


@dataclass(frozen=True, slots=True)
class _Chain:
    """Transforms of a frame to its ancestors, up to the first that is unknown at the time."""

    frames: _Above
    fault: ExtrapolationException | None


def _not_connected(target: str, source: str) -> ConnectivityException:
    return ConnectivityException(
        f"Could not find a connection between '{target}' and '{source}' because they are not "
        "part of the same tree.Tf has two or more unconnected trees."
    )


def _fault(transform: Transform, parent: str, child: str, authority: str) -> str | None:
    """Return the error message for an invalid transform, or None."""
    if child == parent:
        return (
            f'TF_SELF_TRANSFORM: Ignoring transform from authority "{authority}" with frame_id '
            f'and child_frame_id "{child}" because they are the same'
        )
    if not child:
        return (
            f'TF_NO_CHILD_FRAME_ID: Ignoring transform from authority "{authority}" because '
            "child_frame_id not set "
        )
    if not parent:
        return (
            f'TF_NO_FRAME_ID: Ignoring transform with child_frame_id "{child}" from authority '
            f'"{authority}" because frame_id not set'
        )
    numbers = (*transform.translation, *transform.rotation)
    if not all(math.isfinite(number) for number in numbers):
        return (
            f'TF_NAN_INPUT: Ignoring transform for child_frame_id "{child}" from authority '
            f'"{authority}" because of a nan value in the transform {transform}'
        )
    if abs(sum(part * part for part in transform.rotation) - 1.0) > _QUATERNION_TOLERANCE:
        return (
            f'TF_DENORMALIZED_QUATERNION: Ignoring transform for child_frame_id "{child}" from '
            f'authority "{authority}" because of an invalid quaternion in the transform '
            f"{transform.rotation}"
        )
    return None
