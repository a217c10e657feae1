"""``Marker`` and ``MarkerArray``: the markers of a topic, by namespace and id."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from teleopctl.base.printable import printable_line
from teleopctl.tf import Transform, TransformException
from teleopctl.viewer.displays.base import OK, WARN, Display
from teleopctl.viewer.displays.markers.marker_drawing import MarkerError, draw_marker, marker_pose
from teleopctl.viewer.displays.markers.marker_files import MarkerFiles
from teleopctl.viewer.displays.stamped import no_transform_text, pose_at_stamp
from teleopctl.viewer.scene.canvas import Canvas
from teleopctl.viewer.scene.drawing import Drawing, merged

if TYPE_CHECKING:
    from teleopctl.viewer.displays.base import Stage

# Any: messages, whose classes are created from definitions at run time.

ADD, DELETE, DELETE_ALL = 0, 2, 3
# A publisher that never reuses an ID would fill the memory within hours.
MOST_MARKERS = 20_000
# Messages of one marker queued for their transforms, as many as in RViz's message filter.
_WAITING = 10

_HERE = Transform()

Key = tuple[str, int]


@dataclass(slots=True, eq=False)
class _Entry:
    """One marker of a `MarkerSet`.

    Attributes:
        shown: Message that is drawn.
        waiting: Newer messages without a known transform.
        drawing: Drawing of ``shown``.
        group: Frame that the marker moves with (``frame_locked``); empty for the fixed frame.
        file: Key of the marker's mesh or texture; empty for none.
        expires_ns: Time of expiry in nanoseconds; 0 for none.
        fault: Reason why the marker is not drawn as in its message; empty for none.
    """

    shown: Any = None
    waiting: list[Any] = field(default_factory=list)
    drawing: Drawing | None = None
    group: str = ""
    file: str = ""
    expires_ns: int = 0
    fault: str = ""


class MarkerSet:
    """Markers of a display by namespace and ID, with poses, lifetimes and drawings.

    Args:
        stage: The viewer's node.
        root: Scene path below which the markers are drawn.
    """

    def __init__(self, stage: Stage, root: str) -> None:
        self.hidden: set[str] = set()
        self._stage = stage
        self._root = root
        self._entries: dict[Key, _Entry] = {}
        self._canvases: dict[str, Canvas] = {}
        self._files = MarkerFiles(stage, self._file_arrived)
        self._stale: set[str] = set()
        self._waiting: set[Key] = set()
        self._expires_ns = 0
        self._fixed = ""
        self._message_fault = ""

    def __len__(self) -> int:
        return len(self._entries)

    @property
    def namespaces(self) -> list[str]:
        """Sorted list of the namespaces of all markers."""
        return sorted({ns for ns, _ in self._entries})

    # --- messages -----------------------------------------------------------------------------

    def apply(self, markers: Iterable[Any]) -> None:
        """Apply the actions of Marker messages in order: add, modify, delete or delete all."""
        self._message_fault = ""
        seen: set[Key] = set()
        for marker in markers:
            key = (str(marker.ns), int(marker.id))
            if marker.action == ADD:
                if key in seen:
                    self._message_fault = f"{_name(key)} is in the message more than once"
                seen.add(key)
                self._add(key, marker)
            elif marker.action == DELETE:
                self._remove(key)
            elif marker.action == DELETE_ALL:
                self.clear(key[0])
            else:
                self._message_fault = f"{_name(key)} has the unknown action {marker.action}"
        if len(self._entries) > MOST_MARKERS:
            for key in list(self._entries)[: len(self._entries) - MOST_MARKERS]:
                self._remove(key)
            self._message_fault = (
                f"There are more than {MOST_MARKERS} markers: the oldest are removed"
            )
        self.update()

    def clear(self, ns: str = "") -> None:
        """Remove the markers of a namespace, or all markers for an empty namespace."""
        for key in [key for key in self._entries if not ns or key[0] == ns]:
            self._remove(key)

    def _add(self, key: Key, marker: Any) -> None:
        entry = self._entries.get(key)
        if entry is None:
            entry = self._entries[key] = _Entry()
        lifetime_ns = marker.lifetime.sec * 1_000_000_000 + marker.lifetime.nanosec
        entry.expires_ns = 0
        if lifetime_ns > 0:
            entry.expires_ns = self._now_ns() + lifetime_ns
            if not self._expires_ns or entry.expires_ns < self._expires_ns:
                self._expires_ns = entry.expires_ns
        entry.waiting.append(marker)
        del entry.waiting[:-_WAITING]
        self._waiting.add(key)

    def _remove(self, key: Key) -> None:
        entry = self._entries.pop(key, None)
        if entry is not None:
            self._waiting.discard(key)
            self._stale.add(entry.group)

    # --- the picture --------------------------------------------------------------------------

    def update(self) -> None:
        """Make the drawings of markers whose transform is now known; remove expired markers."""
        now_ns = self._now_ns() if self._expires_ns else 0
        if self._expires_ns and now_ns >= self._expires_ns:
            due = [k for k, e in self._entries.items() if 0 < e.expires_ns <= now_ns]
            for key in due:
                self._remove(key)
            left = [entry.expires_ns for entry in self._entries.values() if entry.expires_ns]
            self._expires_ns = min(left, default=0)
        if self._fixed != self._stage.frames.fixed:
            self._fixed = self._stage.frames.fixed
            self._reset_poses()
        if self._waiting:
            self._place()

    def show(self) -> bool:
        """Send changed drawings to the viser scene; return whether anything was sent."""
        if not self._stale:
            return False
        groups: dict[str, list[Drawing]] = {group: [] for group in self._stale}
        for (ns, _), entry in self._entries.items():
            if entry.group in groups and entry.drawing is not None and ns not in self.hidden:
                groups[entry.group].append(entry.drawing)
        for group, drawings in groups.items():
            canvas = self._canvases.get(group)
            if canvas is None:
                above = self._stage.frames.node_path(group) if group else ""
                path = f"{above}{self._root}"
                canvas = Canvas(self._stage.scene, path, self._files.meshes, self._files.textures)
                self._canvases[group] = canvas
            canvas.show(merged(drawings))
            if not drawings:
                del self._canvases[group]
        self._stale.clear()
        self._files.drop_unused({entry.file for entry in self._entries.values()})
        return True

    def set_hidden(self, ns: str, *, hidden: bool) -> None:
        """Show or hide the markers of a namespace, from the next `show` on."""
        (self.hidden.add if hidden else self.hidden.discard)(ns)
        self._stale |= {entry.group for entry in self._entries.values()}

    def remove(self) -> None:
        """Remove all markers from the set and from the scene."""
        self._entries.clear()
        self._waiting.clear()
        self._stale.clear()
        self._message_fault = ""
        self._expires_ns = 0
        for canvas in self._canvases.values():
            canvas.remove()
        self._canvases.clear()

    def fault(self) -> str:
        """Return the first marker's fault as text, and how many more there are; empty for none."""
        faults = [self._message_fault] if self._message_fault else []
        number = len(faults)
        for key, entry in self._entries.items():
            fault = entry.fault or self._files.faults.get(entry.file, "")
            if fault:
                number += 1
                if not faults:
                    named = (
                        fault
                        if fault.startswith(("No ", "Mesh", "Texture"))
                        else f"{_name(key)} {fault}"
                    )
                    faults.append(named)
        if number > 1:
            return f"{faults[0]} ({number - 1} more)"
        return faults[0] if faults else ""

    # --- poses --------------------------------------------------------------------------------

    def _reset_poses(self) -> None:
        """Look up again the poses of markers that do not move with their frame."""
        for key, entry in self._entries.items():
            if entry.shown is not None and not entry.group:
                entry.waiting.insert(0, entry.shown)
                entry.drawing = None
                self._waiting.add(key)
        self._stale.add("")

    def _file_arrived(self) -> None:
        self._stale |= {entry.group for entry in self._entries.values()}

    def _now_ns(self) -> int:
        return int(self._stage.node.get_clock().now().nanoseconds)

    def _place(self) -> None:
        # One lookup for all markers with the same frame and stamp.
        places: dict[tuple[str, int, int], Transform | str] = {}
        waiting, self._waiting = self._waiting, set()
        for key in waiting:
            entry = self._entries[key]
            # The newest message with a transform is drawn; older messages are dropped.
            for number in range(len(entry.waiting) - 1, -1, -1):
                if self._try(entry, entry.waiting[number], places):
                    del entry.waiting[: number + 1]
                    break
            if entry.waiting:
                self._waiting.add(key)

    def _try(
        self, entry: _Entry, marker: Any, places: dict[tuple[str, int, int], Transform | str]
    ) -> bool:
        header = marker.header
        try:
            pose = marker_pose(marker)
            group = header.frame_id.removeprefix("/") if marker.frame_locked else ""
            if not group:
                about = (header.frame_id, header.stamp.sec, header.stamp.nanosec)
                place = places.get(about)
                if place is None:
                    try:
                        place = pose_at_stamp(self._stage.frames, header)
                    except TransformException as error:
                        place = no_transform_text(header, self._fixed, error)
                    places[about] = place
                if isinstance(place, str):
                    entry.fault = place
                    return False
                if place != _HERE:
                    pose = place @ pose
            file = self._files.request(marker)
            drawing, entry.fault = draw_marker(marker, pose)
        except MarkerError as fault:
            # The former drawing of the marker is kept, as in RViz.
            entry.fault = str(fault)
            return True
        self._stale |= {entry.group, group}
        entry.shown, entry.drawing, entry.group, entry.file = marker, drawing, group, file
        return True


def _name(key: Key) -> str:
    ns, number = key
    return f"Marker {printable_line(f'{ns}/{number}' if ns else str(number))}"


# A longer list is not readable.
_MOST_NAMESPACES = 100


class Marker(Display):
    """RViz's ``Marker`` display: the markers of a topic."""

    rviz_class = "Marker"
    message_type = "visualization_msgs/msg/Marker"
    parts_title: ClassVar[str] = "Namespaces"

    def _prepare(self) -> None:
        self.markers = MarkerSet(self.stage, self.root)
        said = self.values.given.get("Namespaces")
        if not isinstance(said, dict):
            said = self.values.given["Namespaces"] = {}
        # YAML may have read namespaces as numbers.
        self._shown_parts: dict[Any, Any] = said
        self.markers.hidden = {str(ns) for ns, shown in said.items() if shown is False}

    def received(self, message: Any) -> None:
        """Apply the action of a Marker message, and set the status."""
        self._apply((message,))

    def _apply(self, markers: Any) -> None:
        self.markers.apply(markers)
        self._update_status()

    def tick(self) -> None:
        """Update poses, remove expired markers, and send changed drawings to the scene."""
        self.markers.update()
        if self.markers.show():
            known = {str(ns) for ns in self._shown_parts}
            for ns in self.markers.namespaces:
                if ns not in known and len(self._shown_parts) < _MOST_NAMESPACES:
                    self._shown_parts[ns] = True
            self._update_status()

    def _update_status(self) -> None:
        fault = self.markers.fault()
        self.set_status(WARN if fault else OK, fault)

    def parts(self) -> dict[str, bool]:
        """Return by name whether each namespace is shown; see `Display.parts`."""
        return {str(ns): shown is not False for ns, shown in self._shown_parts.items()}

    def show_part(self, name: str, *, shown: bool) -> None:
        """Show or hide the markers of a namespace."""
        key = next((ns for ns in self._shown_parts if str(ns) == name), name)
        self._shown_parts[key] = shown
        self.markers.set_hidden(name, hidden=not shown)

    def stopped(self) -> None:
        """Remove all markers from the scene; called when the display stops."""
        self.markers.remove()


class MarkerArray(Marker):
    """RViz's ``MarkerArray`` display: the markers of a topic of arrays."""

    rviz_class = "MarkerArray"
    message_type = "visualization_msgs/msg/MarkerArray"

    def received(self, message: Any) -> None:
        """Apply the actions of a MarkerArray's markers in order, and set the status."""
        self._apply(message.markers)
