"""The tf frames in the scene, and the tf buffer with a limited number of frames.

Each frame of ``/tf`` is one scene node, with the frame's pose in the fixed frame. The frame's axes
and the geometry of links are child nodes, so that only one pose is sent for each moved frame.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from teleopctl.tf import LiveBuffer, Transform

if TYPE_CHECKING:
    import viser
    from geometry_msgs.msg import TransformStamped

    from teleopctl.node import Node, Time

MOST_FRAMES = 1000
"""Largest number of frames in a buffer; updating so many takes a fifth of a core."""

SILENT_S = 15.0
"""Seconds without a transform after which a frame may be dropped to make room."""

# Least time between searches for silent frames, and largest share dropped by one search.
_LOOKS_EVERY_S = 1.0
# Longest time for which one update moves frames, looked at after some of them.
_LONGEST_S = 0.02
_MOVES_PER_LOOK = 32
_SHARE_FORGOTTEN = 0.1
# Duration of the status after a full buffer.
_FULL_SHOWN_S = 10.0


class FrameBuffer(LiveBuffer):
    """tf buffer with at most `MOST_FRAMES` frames, which drops the ones silent for longest.

    tf2 never drops a frame. A program that gives each detected object a new frame would fill the
    memory of the page and of every browser.

    When the limit is reached, the frames without transforms for the longest time are dropped,
    except static frames and parents of other frames. If no frame can be dropped, new frames are
    rejected.

    Args:
        node: See `LiveBuffer`.
    """

    def __init__(self, node: Node | None = None) -> None:
        super().__init__(node=node)
        # Time of each frame's last transform; infinity for static frames.
        self._received: dict[str, float] = {}
        self._looked_s = self._full_s = -math.inf

    @property
    def is_full(self) -> bool:
        """Whether frames were dropped or rejected for lack of room in the last 10 s."""
        return time.monotonic() - self._full_s < _FULL_SHOWN_S

    def stale_frames(self, longer_than_s: float) -> set[str]:
        """Return moving frames whose last transform is that much older than the newest one.

        No frame is stale while all frames have stopped, as in a paused simulation.

        Args:
            longer_than_s: Smallest difference in seconds.
        """
        with self._changed:
            moving = {name: at_s for name, at_s in self._received.items() if at_s < math.inf}
        since_s = max(moving.values(), default=0.0) - longer_than_s
        return {name for name, at_s in moving.items() if at_s < since_s}

    def ages(self) -> dict[str, tuple[str, float | None]]:
        """Return by frame the parent and the age of the last transform (s); None if static."""
        now_s = time.monotonic()
        parents = {name: sample.parent for name, sample in self.latest()}
        with self._changed:
            received = dict(self._received)
        return {
            name: (parent, None if math.isinf(at_s) else now_s - at_s)
            for name, parent in parents.items()
            if (at_s := received.get(name)) is not None
        }

    def clear(self) -> None:
        """Drop the transforms of all moving frames, and keep the static ones."""
        with self._changed:
            super().clear()
            self._received = {
                name: at_s for name, at_s in self._received.items() if math.isinf(at_s)
            }

    def forget(self, frames: Iterable[str]) -> None:
        """Remove frames from the buffer, and parents that no remaining frame refers to."""
        names = tuple(frames)
        with self._changed:
            super().forget(names)
            for name in names:
                self._received.pop(name, None)

    def _admits(self, message: TransformStamped, authority: str, *, static: bool) -> bool:
        name, now_s = message.child_frame_id.removeprefix("/"), time.monotonic()
        if name not in self._received and not self._has_room(now_s):
            return False
        if not super()._admits(message, authority, static=static):
            return False
        self._received[name] = math.inf if static else now_s
        if len(self._tree) > 2 * MOST_FRAMES:
            # Each frame may have its own parent; further frames are unused former parents.
            self.forget(())
        return True

    def _has_room(self, now_s: float) -> bool:
        if len(self._received) < MOST_FRAMES:
            return True
        self._full_s = now_s
        if now_s - self._looked_s >= _LOOKS_EVERY_S:
            self._looked_s = now_s
            self._make_room(now_s)
        return len(self._received) < MOST_FRAMES

    def _make_room(self, now_s: float) -> None:
        parents = {name: sample.parent for name, sample in self.latest()}
        silent = {name for name, at_s in self._received.items() if now_s - at_s > SILENT_S}
        for name in self._received.keys() - silent:
            above = parents.get(name, "")
            while above in silent:
                silent.remove(above)
                above = parents.get(above, "")
        oldest_first = sorted(silent, key=self._received.__getitem__)
        gone = oldest_first[: math.ceil(MOST_FRAMES * _SHARE_FORGOTTEN)]
        self.forget(gone)


# Decoding thousands of transforms takes a twentieth of a second, in which the page answers slowly:
# messages above this size are taken four times a second.
_LARGE_MESSAGE = 60_000
_LARGE_PERIOD_S = 0.25
_MOST_SIZES = 100


class LargeTransforms:
    """Choice of the messages of ``/tf`` that are decoded, by their size.

    Messages of one size are those of one publisher, which sends all its frames in each of them.
    """

    def __init__(self) -> None:
        self._next_s: dict[int, float] = {}

    def is_taken(self, size: int) -> bool:
        """Return whether a message is decoded.

        Args:
            size: Size of the message in bytes.
        """
        if size < _LARGE_MESSAGE:
            return True
        now_s = time.monotonic()
        if now_s < self._next_s.get(size, 0.0):
            return False
        if len(self._next_s) > _MOST_SIZES:
            self._next_s.clear()
        self._next_s[size] = now_s + _LARGE_PERIOD_S
        return True


_IDENTITY = Transform()
# Far more than any robot has. A program that gives each object a new frame would fill the memory of
# the page and of each browser.
MOST_UNKNOWN = 1000
# As in RViz: 0.2 m long, 0.02 m thick.
_AXES_LENGTH_M = 0.2
_AXES_RADIUS_M = 0.01


@dataclass(slots=True)
class Frame:
    """A tf frame as a scene node: name, label, and pose in the fixed frame.

    Attributes:
        name: Name of the frame in tf.
        node: Scene node of the frame.
        label: Label with the name in the scene; None if not shown.
        pose: Pose in the fixed frame; None without a transform.
        is_silent: Whether a transform between the frame and the fixed frame is stale, so that axes
            and name are hidden.
    """

    name: str
    node: viser.FrameHandle
    label: viser.LabelHandle | None = None
    pose: Transform | None = None
    is_silent: bool = False


class SceneFrames:
    """The tf frames as scene nodes, with their poses in the fixed frame, axes and names.

    Args:
        scene: The viser scene.
        buffer: The tf buffer.

    Attributes:
        by_name: Frames in the scene by name.
    """

    def __init__(self, scene: viser.SceneApi, buffer: FrameBuffer) -> None:
        self.buffer = buffer
        self.by_name: dict[str, Frame] = {}
        self._scene = scene
        self._fixed = ""
        self._wanted_fixed = ""
        self._axes_shown = False
        self._names_shown = False
        self._scale = 1.0
        self._timeout_s = math.inf
        self._which: Callable[[str], bool] = lambda _name: True
        self._looked_s = -math.inf
        # Number of the frame that the next update begins with.
        self._next = 0

    @property
    def fixed(self) -> str:
        """Name of the fixed frame; empty until a frame is known."""
        return self._fixed

    def set_fixed_frame(self, name: str) -> None:
        """Set the fixed frame for the next `update`; empty for the root of the largest tf tree."""
        self._wanted_fixed = name.removeprefix("/")

    def set_appearance(
        self,
        *,
        axes: bool,
        names: bool,
        scale: float = 1.0,
        timeout_s: float = math.inf,
        which: Callable[[str], bool] = lambda _name: True,
    ) -> None:
        """Set whether, and for which frames, axes and names are shown, and their size.

        Args:
            axes: Whether axes are shown: x red, y green, z blue.
            names: Whether names are shown.
            scale: Size of the axes; 1 is 0.2 m.
            timeout_s: See `FrameBuffer.stale_frames`; axes and names of stale frames are hidden.
            which: Function that returns whether axes and name of a frame are shown, called with the
                frame's name.
        """
        self._axes_shown, self._names_shown, self._scale = axes, names, scale
        self._which = which
        self._timeout_s, self._looked_s = timeout_s, -math.inf
        for frame in self.by_name.values():
            self._update_appearance(frame)

    def node_path(self, name: str) -> str:
        """Return the scene path of a tf frame's node, which is created if needed."""
        return self._frame(name).node.name

    def update(self) -> None:
        """Update the poses of all frames from the tf buffer, and select a default fixed frame."""
        latest = dict(self.buffer.latest())
        parents = {child: sample.parent for child, sample in latest.items()}
        self._choose_fixed(parents)
        local = {child: sample.transform for child, sample in latest.items()}
        poses, tops = _poses_in_roots(parents, local)
        top = tops.get(self._fixed, self._fixed)
        to_fixed = poses.get(self._fixed, _IDENTITY).inverse()
        names = (*poses, *(self.by_name.keys() - poses.keys()))
        begun_s, moved = time.monotonic(), 0
        for number in range(len(names)):
            name = names[(self._next + number) % len(names)]
            joined = tops.get(name, name) == top
            pose = to_fixed @ poses.get(name, _IDENTITY) if joined else None
            moved += self._move(self._frame(name), pose)
            if moved and moved % _MOVES_PER_LOOK == 0 and time.monotonic() - begun_s > _LONGEST_S:
                # Of thousands of frames the others follow next, so that the page answers between.
                self._next = (self._next + number + 1) % len(names)
                break
        else:
            self._next = 0
        self._forget(poses)
        self._hide_stale(parents, poses)

    def pose_in_fixed_frame(self, frame: str, stamp: Time | None = None) -> Transform:
        """Return a frame's pose in the fixed frame at a stamp, by default the newest.

        Args:
            frame: Name of the frame.
            stamp: Time of the pose; None or 0 for the newest.

        Raises:
            TransformException: The transform is not known.
        """
        frame = frame.removeprefix("/")
        # Without any tf, the first frame with a drawing becomes the fixed frame.
        if not self._fixed and not self._wanted_fixed:
            self._fixed = frame
        if frame == self._fixed:
            return _IDENTITY
        stamp_ns = 0 if stamp is None else stamp.nanoseconds
        return self.buffer.lookup(self._fixed, frame, stamp_ns)[1]

    def remove(self) -> None:
        """Remove all tf frames from the scene."""
        for frame in self.by_name.values():
            frame.node.remove()
        self.by_name.clear()

    def _forget(self, known: Mapping[str, Transform]) -> None:
        """Remove the oldest frames without transforms beyond `MOST_UNKNOWN`."""
        unknown = [name for name in self.by_name if name not in known and name != self._fixed]
        for name in unknown[: max(len(unknown) - MOST_UNKNOWN, 0)]:
            self.by_name.pop(name).node.remove()

    def _hide_stale(self, parents: Mapping[str, str], downwards: Iterable[str]) -> None:
        """Hide axes and names of stale frames and of frames below them, once a second."""
        now_s = time.monotonic()
        if now_s - self._looked_s < _LOOKS_EVERY_S:
            return
        self._looked_s = now_s
        silent = _behind_stale(
            self.buffer.stale_frames(self._timeout_s), parents, downwards, self._fixed
        )
        for name, frame in self.by_name.items():
            if frame.is_silent != (name in silent):
                frame.is_silent = name in silent
                self._update_appearance(frame)

    def _choose_fixed(self, parents: dict[str, str]) -> None:
        if self._wanted_fixed:
            self._fixed = self._wanted_fixed
        elif parents and (self._fixed in parents or self._fixed not in parents.values()):
            # the root of the largest tree
            roots: dict[str, int] = {}
            for name in parents:
                root = _root_of(name, parents)
                roots[root] = roots.get(root, 0) + 1
            self._fixed = max(roots, key=lambda root: (roots[root], root))

    def _frame(self, name: str) -> Frame:
        name = name.removeprefix("/")
        frame = self.by_name.get(name)
        if frame is None:
            node = self._scene.add_frame(f"/frames/{scene_path_part(name)}", show_axes=False)
            node.visible = name == self._fixed
            frame = self.by_name[name] = Frame(name, node)
            self._update_appearance(frame)
        return frame

    def _update_appearance(self, frame: Frame) -> None:
        frame.node.axes_length = _AXES_LENGTH_M * self._scale
        frame.node.axes_radius = _AXES_RADIUS_M * self._scale
        frame.node.origin_radius = _AXES_RADIUS_M * self._scale
        shown = not frame.is_silent and self._which(frame.name)
        frame.node.show_axes = self._axes_shown and shown
        named = self._names_shown and shown
        if named and frame.label is None:
            frame.label = self._scene.add_label(f"{frame.node.name}/name", frame.name)
        elif not named and frame.label is not None:
            frame.label.remove()
            frame.label = None

    def _move(self, frame: Frame, pose: Transform | None) -> bool:
        """Move a frame's node; return whether it was elsewhere."""
        if pose == frame.pose:
            return False
        if pose is not None:
            x, y, z, w = pose.rotation
            if frame.pose is None or pose.rotation != frame.pose.rotation:
                frame.node.wxyz = (w, x, y, z)
            if frame.pose is None or pose.translation != frame.pose.translation:
                frame.node.position = pose.translation
        if (pose is None) != (frame.pose is None):
            frame.node.visible = pose is not None
        frame.pose = pose
        return True


def scene_path_part(name: str) -> str:
    """Return a frame's name as one part of a viser scene path, with slashes replaced."""
    return name.replace("/", "\u2215") or "_"


def _root_of(name: str, parents: dict[str, str]) -> str:
    for _ in range(len(parents)):
        if name not in parents:
            break
        name = parents[name]
    return name


def _poses_in_roots(
    parents: dict[str, str], local: dict[str, Transform]
) -> tuple[dict[str, Transform], dict[str, str]]:
    """Return each frame's pose in the root of its tree, and the name of that root."""
    poses: dict[str, Transform] = {}
    tops: dict[str, str] = {}
    for name in parents:
        chain: list[str] = []
        while name in parents and name not in poses and len(chain) <= len(parents):
            chain.append(name)
            name = parents[name]
        if name not in poses:
            poses[name], tops[name] = _IDENTITY, name
        for child in reversed(chain):
            parent = parents[child]
            poses[child] = poses.get(parent, _IDENTITY) @ local[child]
            tops[child] = tops.get(parent, parent)
    return poses, tops


def _behind_stale(
    silent: set[str], parents: Mapping[str, str], downwards: Iterable[str], fixed: str
) -> set[str]:
    """Return the frames with a stale frame between them and the fixed frame.

    Args:
        silent: The stale frames.
        parents: Parent of each frame.
        downwards: All frames, each after its parent.
        fixed: The fixed frame.
    """
    joined = {fixed: False}
    name = fixed
    while (above := parents.get(name)) is not None and above not in joined:
        joined[above] = joined[name] or name in silent
        name = above
    for name in downwards:
        if name not in joined:
            joined[name] = name in silent or joined.get(parents.get(name, ""), False)
    return {name for name, is_silent in joined.items() if is_silent}
