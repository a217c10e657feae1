"""Where the frames of an SDF model are: poses that are relative to one another."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.scene.scene import NOWHERE, SceneModel
from teleopctl.robot.sdf.reading import SdfFile, relative_to
from teleopctl.tf import Transform

MODEL = "__model__"
_ORIGINS = (MODEL, "world", "")


class _Placed(NamedTuple):
    """Where a frame is in another one, and the element that says so."""

    relative: str
    pose: Transform
    # Any: an element of lxml.
    element: Any


@dataclass
class SdfFrames:
    """Frames of a model or world, by name.

    Attributes:
        file: The file.
        attached: What frames that are no links are fixed to: a link, or another frame.
    """

    file: SdfFile
    attached: dict[str, str] = field(default_factory=dict)
    _placed: dict[str, _Placed] = field(default_factory=dict)
    _known: dict[str, Transform] = field(default_factory=dict)

    # Any, here and below: elements of lxml.
    def put(self, name: str, element: Any, default: str = MODEL) -> None:
        """Add the frame of an element with a ``<pose>``.

        Args:
            name: What it is called.
            element: A link, a joint or a frame.
            default: What its pose is relative to unless it says.
        """
        pose = element.find("pose")
        self.put_at(name, relative_to(pose) or default, self.file.pose(pose), element)

    def put_at(self, name: str, relative: str, pose: Transform, element: Any) -> None:
        """Add a frame by its pose relative to another one."""
        self._placed[name] = _Placed(relative, pose, element)

    def put_model(self, model: SceneModel, element: Any, prefix: str) -> None:
        """Add the frames of a nested model.

        Args:
            model: The model.
            element: Its ``<model>`` or ``<include>``.
            prefix: In front of the names of those in it.
        """
        self.put_at(model.name, relative_to(element.find("pose")) or MODEL, model.pose, element)
        self.attached[model.name] = f"{prefix}{next(iter(model.bodies), '')}"
        for name, (link, pose) in model.frames.items():
            self.put_at(f"{prefix}{name}", model.name, pose, element)
            if link != name:
                self.attached[f"{prefix}{name}"] = f"{prefix}{link}"

    def __iter__(self) -> Iterator[str]:
        return iter(self._placed)

    def find(self, name: str, asker: Any) -> Transform:
        """Return the pose of a frame in the model.

        Args:
            name: The frame.
            asker: The element that names it, for errors.

        Raises:
            InvalidDescriptionError: There is none, or it is relative to itself.
        """
        path: dict[str, None] = {}
        while name not in self._known and name not in _ORIGINS:
            if name in path:
                raise InvalidDescriptionError(
                    f"{self.file.place(asker)}: frame '{name}' is, in the end, relative to itself"
                )
            if name not in self._placed:
                raise InvalidDescriptionError(
                    f"{self.file.place(asker)}: there is no frame '{name}'"
                )
            path[name] = None
            name, _, asker = self._placed[name]
        place = self._known.get(name, NOWHERE)
        for name in reversed(path):
            place = place @ self._placed[name].pose
            self._known[name] = place
        return place

    def link_of(self, name: str) -> str:
        """Return the link that a frame is attached to."""
        met = {name}
        while (name := self.attached.get(name, name)) not in met:
            met.add(name)
        return name
