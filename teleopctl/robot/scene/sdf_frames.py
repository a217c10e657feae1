"""Where the frames of an SDF model are: poses that are relative to one another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.scene.scene import NOWHERE
from teleopctl.robot.scene.sdf_reading import SdfFile
from teleopctl.tf import Transform

MODEL = "__model__"


@dataclass
class Frames:
    """The frames of one model, or of a world, by name.

    Attributes:
        file: The file.
    """

    file: SdfFile
    # Any: elements of lxml.
    _poses: dict[str, tuple[str, Callable[[], Transform], Any]] = field(default_factory=dict)
    _known: dict[str, Transform] = field(default_factory=dict)

    def put(self, name: str, element: Any, default: str = MODEL) -> None:
        """Add the frame of an element with a ``<pose>``.

        Args:
            name: What it is called.
            element: A link, a joint, a frame or a model.
            default: What its pose is relative to unless it says.
        """
        pose = element.find("pose")
        relative = None if pose is None else (pose.get("relative_to") or pose.get("frame"))
        if element.tag == "frame" and not relative:
            relative = element.get("attached_to")
        self._poses[name] = (relative or default, lambda: self.file.pose(pose), element)

    def put_fixed(self, name: str, pose: Transform) -> None:
        """Add a frame whose place in the model is known."""
        self._known[name] = pose

    def __contains__(self, name: object) -> bool:
        return name in self._poses or name in self._known

    def find(self, name: str, asker: Any, _path: tuple[str, ...] = ()) -> Transform:
        """Where a frame is in the model.

        Args:
            name: The frame.
            asker: The element that names it, for errors.

        Raises:
            InvalidDescriptionError: There is none, or it is relative to itself.
        """
        if name in (MODEL, "world", ""):
            return NOWHERE
        if name in self._known:
            return self._known[name]
        if name in _path:
            raise InvalidDescriptionError(
                f"{self.file.place(asker)}: frame '{name}' is, in the end, relative to itself"
            )
        if name not in self._poses:
            raise InvalidDescriptionError(f"{self.file.place(asker)}: there is no frame '{name}'")
        relative, pose, element = self._poses[name]
        place = self.find(relative, element, (*_path, name)) @ pose()
        self._known[name] = place
        return place
