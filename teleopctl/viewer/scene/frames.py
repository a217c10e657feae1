"""Where every frame stands in the fixed frame, and its place in the picture.

Each frame of ``/tf`` is one node of the scene, standing in the fixed frame. What belongs to a frame
(its axes, its name, the geometry of a link) hangs below that node and moves with it, so that one
pose is sent for each frame that has moved.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from teleopctl.tf import Transform
from teleopctl.viewer.scene.frame_buffer import FrameBuffer

if TYPE_CHECKING:
    import viser

    from teleopctl.node import Time

_IDENTITY = Transform()
# Far more than any robot has. A program that never names a frame twice would fill the memory of the
# page and of each browser.
MOST_UNKNOWN = 1000
# How often is looked for frames that have become silent.
_LOOKS_EVERY_S = 1.0
# As RViz draws them: 0.2 m long, 0.02 m thick.
_AXES_LENGTH_M = 0.2
_AXES_RADIUS_M = 0.01


@dataclass(slots=True)
class Frame:
    """A tf frame's node in the scene.

    Attributes:
        name: Its name in tf.
        node: Its node in the scene.
        label: Its name in the picture, where that is shown.
        pose: Where it stands in the fixed frame; None where nothing joins the two.
        is_silent: Whether what joins the two has been silent for too long to dress it.
    """

    name: str
    node: viser.FrameHandle
    label: viser.LabelHandle | None = None
    pose: Transform | None = None
    is_silent: bool = False


class SceneFrames:
    """The tf frames in the scene, with axes, names and poses.

    Args:
        scene: Where to draw.
        buffer: What is known of frames.

    Attributes:
        by_name: The frames in the picture.
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

    @property
    def fixed(self) -> str:
        """The fixed frame; empty until one is known."""
        return self._fixed

    def fix(self, name: str) -> None:
        """Set the fixed frame; an empty name means the tree's root."""
        self._wanted_fixed = name.removeprefix("/")

    def show(
        self,
        *,
        axes: bool,
        names: bool,
        scale: float = 1.0,
        timeout_s: float = math.inf,
        which: Callable[[str], bool] = lambda _name: True,
    ) -> None:
        """Set which axes, arrows and names are shown.

        Args:
            axes: Whether its axes are: x red, y green, z blue.
            names: Whether its name is.
            scale: Size of the axes; 1 is 0.2 m.
            timeout_s: For how long a frame may be silent while others are not; the axes and the
                name of one that is for longer are taken away.
            which: Of which frames anything is, by name.
        """
        self._axes_shown, self._names_shown, self._scale = axes, names, scale
        self._which = which
        self._timeout_s, self._looked_s = timeout_s, -math.inf
        for frame in self.by_name.values():
            self._dress(frame)

    def node_of(self, name: str) -> str:
        """Return the scene path of a frame, whose node is made if it is new."""
        return self._frame(name).node.name

    def update(self) -> None:
        """Update the poses of all frames."""
        latest = dict(self.buffer.latest())
        parents = {child: sample.parent for child, sample in latest.items()}
        self._choose_fixed(parents)
        local = {child: sample.transform for child, sample in latest.items()}
        poses, tops = _poses_in_roots(parents, local)
        top = tops.get(self._fixed, self._fixed)
        to_fixed = poses.get(self._fixed, _IDENTITY).inverse()
        for name in (*poses, *(self.by_name.keys() - poses.keys())):
            joined = tops.get(name, name) == top
            self._move(self._frame(name), to_fixed @ poses.get(name, _IDENTITY) if joined else None)
        self._forget(poses)
        self._undress_silent(parents, poses)

    def pose_in_fixed(self, frame: str, stamp: Time | None = None) -> Transform:
        """Return the pose of a frame in the fixed frame.

        Args:
            frame: Its name.
            stamp: When; None or 0 is the newest that is known.

        Raises:
            TransformException: That is not known.
        """
        frame = frame.removeprefix("/")
        # Without any tf the first frame that something stands in is as good as any.
        if not self._fixed and not self._wanted_fixed:
            self._fixed = frame
        if frame == self._fixed:
            return _IDENTITY
        stamp_ns = 0 if stamp is None else stamp.nanoseconds
        return self.buffer.lookup(self._fixed, frame, stamp_ns)[1]

    def remove(self) -> None:
        """Remove all frames from the scene."""
        for frame in self.by_name.values():
            frame.node.remove()
        self.by_name.clear()

    def _forget(self, known: Mapping[str, Transform]) -> None:
        """Take out the oldest of the frames that somebody has spoken of and tf does not know."""
        unknown = [name for name in self.by_name if name not in known and name != self._fixed]
        for name in unknown[: max(len(unknown) - MOST_UNKNOWN, 0)]:
            self.by_name.pop(name).node.remove()

    def _undress_silent(self, parents: Mapping[str, str], downwards: Iterable[str]) -> None:
        """Take the axes and names of silent frames away, and of those that stand in such."""
        now_s = time.monotonic()
        if now_s - self._looked_s < _LOOKS_EVERY_S:
            return
        self._looked_s = now_s
        silent = _joined_by(self.buffer.silent(self._timeout_s), parents, downwards, self._fixed)
        for name, frame in self.by_name.items():
            if frame.is_silent != (name in silent):
                frame.is_silent = name in silent
                self._dress(frame)

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
            node = self._scene.add_frame(f"/frames/{scene_name(name)}", show_axes=False)
            node.visible = name == self._fixed
            frame = self.by_name[name] = Frame(name, node)
            self._dress(frame)
        return frame

    def _dress(self, frame: Frame) -> None:
        frame.node.axes_length = _AXES_LENGTH_M * self._scale
        frame.node.axes_radius = _AXES_RADIUS_M * self._scale
        frame.node.origin_radius = _AXES_RADIUS_M * self._scale
        dressed = not frame.is_silent and self._which(frame.name)
        frame.node.show_axes = self._axes_shown and dressed
        named = self._names_shown and dressed
        if named and frame.label is None:
            frame.label = self._scene.add_label(f"{frame.node.name}/name", frame.name)
        elif not named and frame.label is not None:
            frame.label.remove()
            frame.label = None

    def _move(self, frame: Frame, pose: Transform | None) -> None:
        if pose == frame.pose:
            return
        if pose is not None:
            x, y, z, w = pose.rotation
            if frame.pose is None or pose.rotation != frame.pose.rotation:
                frame.node.wxyz = (w, x, y, z)
            if frame.pose is None or pose.translation != frame.pose.translation:
                frame.node.position = pose.translation
        if (pose is None) != (frame.pose is None):
            frame.node.visible = pose is not None
        frame.pose = pose


def scene_name(name: str) -> str:
    """Return a name as one part of a scene path, with slashes escaped."""
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
    """Where each frame stands in the root of its tree, and which root that is."""
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


def _joined_by(
    silent: set[str], parents: Mapping[str, str], downwards: Iterable[str], fixed: str
) -> set[str]:
    """The frames between which and the fixed frame one is silent.

    Args:
        silent: Those that are.
        parents: What each frame stands in.
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
