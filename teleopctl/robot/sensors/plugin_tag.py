"""``<plugin>``: a simulator's plug-in, of a sensor or of a whole robot."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from teleopctl.robot.elements import XmlElement, required


@dataclass(frozen=True, slots=True)
class PluginTag:
    """Gazebo plug-in with its parameters.

    ``parameters`` maps the path of each element without children (``camera_name``,
    ``ros/remapping``) to the texts that stand there. ``line`` is where the tag stands in the
    URDF; 0 where that is not known.
    """

    name: str
    filename: str
    parameters: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    line: int = 0

    @property
    def runs_controllers(self) -> bool:
        """Whether the plug-in is ros2_control's, with a controller manager."""
        return "ros2_control" in self.filename

    def parameter(self, path: str, default: str = "") -> str:
        """Return the first text at a path, or the default."""
        return self.parameters.get(path, (default,))[0]


def read_plugin(element: XmlElement) -> PluginTag:
    """Read a ``<plugin>``."""
    parameters: dict[str, list[str]] = {}

    def collect(parent: XmlElement, prefix: str) -> None:
        for child in parent:
            path = f"{prefix}{child.tag}"
            if next(iter(child), None) is None:
                parameters.setdefault(path, []).append((child.text or "").strip())
            else:
                collect(child, f"{path}/")

    collect(element, "")
    return PluginTag(
        name=element.get("name") or "",
        filename=required(element, "filename"),
        parameters={path: tuple(texts) for path, texts in parameters.items()},
        line=element.sourceline or 0,
    )
