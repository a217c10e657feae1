"""``Marker`` and ``MarkerArray``: whatever a program wants to be seen."""

from __future__ import annotations

from typing import Any, ClassVar

from teleopctl.viewer.displays.base import OK, WARN, Display
from teleopctl.viewer.displays.markers.marker_set import MarkerSet

# Any stands for messages: their classes are made at run time, from definitions.

# More namespaces than these are no list that anybody reads.
_MOST_NAMESPACES = 100


class Marker(Display):
    """Display of a topic's markers."""

    rviz_class = "Marker"
    message_type = "visualization_msgs/msg/Marker"
    parts_title: ClassVar[str] = "Namespaces"

    def _prepare(self) -> None:
        self.markers = MarkerSet(self.stage, self.root)
        said = self.values.given.get("Namespaces")
        if not isinstance(said, dict):
            said = self.values.given["Namespaces"] = {}
        # Namespaces may look like numbers.
        self._shown_parts: dict[Any, Any] = said
        self.markers.hidden = {str(ns) for ns, shown in said.items() if shown is False}

    def received(self, message: Any) -> None:
        """Add, modify or delete a marker."""
        self._take_all((message,))

    def _take_all(self, markers: Any) -> None:
        self.markers.take(markers)
        self._tell()

    def tick(self) -> None:
        """Update poses, and remove markers whose lifetime is over."""
        self.markers.follow()
        if self.markers.show():
            known = {str(ns) for ns in self._shown_parts}
            for ns in self.markers.namespaces:
                if ns not in known and len(self._shown_parts) < _MOST_NAMESPACES:
                    self._shown_parts[ns] = True
            self._tell()

    def _tell(self) -> None:
        fault = self.markers.fault()
        self.say(WARN if fault else OK, fault)

    def parts(self) -> dict[str, bool]:
        """Return the namespaces, with their visibility."""
        return {str(ns): shown is not False for ns, shown in self._shown_parts.items()}

    def show_part(self, name: str, *, shown: bool) -> None:
        """Show or hide a namespace."""
        key = next((ns for ns in self._shown_parts if str(ns) == name), name)
        self._shown_parts[key] = shown
        self.markers.hide(name, hidden=not shown)

    def stopped(self) -> None:
        """Remove everything from the scene."""
        self.markers.remove()


class MarkerArray(Marker):
    """Display of a topic's marker arrays."""

    rviz_class = "MarkerArray"
    message_type = "visualization_msgs/msg/MarkerArray"

    def received(self, message: Any) -> None:
        """Add, modify or delete the markers of an array."""
        self._take_all(message.markers)
