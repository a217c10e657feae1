"""``interactive_markers.menu_handler``. Menus of interactive markers."""

import sys
from dataclasses import dataclass, field

from visualization_msgs.msg import InteractiveMarkerFeedback, MenuEntry

from interactive_markers.interactive_marker_server import FeedbackCallback, InteractiveMarkerServer

__all__ = ["MenuHandler"]

_MARKS = ("", "[x] ", "[ ] ")


@dataclass
class _Entry:
    title: str
    command: str
    command_type: int
    callback: FeedbackCallback | None
    below: list[int] = field(default_factory=list)
    is_visible: bool = True
    check_state: int = 0


class MenuHandler:
    """Menu whose entries call functions; entries have numbers.

    Example:
        >>> menu = MenuHandler()
        >>> top = menu.insert("Move")
        >>> menu.insert("Home", parent=top, callback=lambda feedback: print("home"))
        >>> menu.apply(server, "gripper")
    """

    NO_CHECKBOX = 0
    CHECKED = 1
    UNCHECKED = 2

    def __init__(self) -> None:
        self._entries: dict[int, _Entry] = {}
        self._top: list[int] = []
        self._markers: set[str] = set()

    def insert(
        self,
        title: str,
        parent: int | None = None,
        command_type: int = MenuEntry.FEEDBACK,
        command: str = "",
        callback: FeedbackCallback | None = None,
    ) -> int | None:
        """Add an entry; return its number, or None if there is no entry of the parent's number.

        Args:
            title: Text of the entry.
            parent: Number of the entry above; None for the top of the menu.
            command_type: What a client does: send feedback, or run a command.
            command: Command of the entry.
            callback: Called when the entry is chosen.
        """
        if parent is not None and parent not in self._entries:
            print(f"Parent menu entry '{parent}' not found", file=sys.stderr)  # noqa: T201 -- as ROS 2
            return None
        handle = len(self._entries) + 1
        self._entries[handle] = _Entry(title, command, command_type, callback)
        (self._top if parent is None else self._entries[parent].below).append(handle)
        return handle

    def setVisible(self, handle: int, visible: bool) -> bool:
        """Show or hide an entry; return False if there is none."""
        if handle in self._entries:
            self._entries[handle].is_visible = visible
        return handle in self._entries

    def setCheckState(self, handle: int, check_state: int) -> bool:
        """Set the check box of an entry; return False if there is none."""
        if handle in self._entries:
            self._entries[handle].check_state = check_state
        return handle in self._entries

    def getCheckState(self, handle: int) -> int | None:
        """Return the check box of an entry; None if there is no such entry."""
        return self._entries[handle].check_state if handle in self._entries else None

    def getTitle(self, handle: int) -> str | None:
        """Return the text of an entry; None if there is no such entry."""
        return self._entries[handle].title if handle in self._entries else None

    def apply(self, server: InteractiveMarkerServer, marker_name: str) -> bool:
        """Give a marker this menu; return False if there is no such marker."""
        marker = server.get(marker_name)
        if marker is None:
            self._markers.discard(marker_name)
            return False
        marker.menu_entries = self._messages(self._top, 0)
        server.insert(
            marker,
            feedback_callback=self.processFeedback,
            feedback_type=InteractiveMarkerFeedback.MENU_SELECT,
        )
        self._markers.add(marker_name)
        return True

    def reApply(self, server: InteractiveMarkerServer) -> bool:
        """Give all markers of `apply` the present menu; return whether all are there."""
        applied = [self.apply(server, name) for name in tuple(self._markers)]
        return all(applied)

    def processFeedback(self, feedback: InteractiveMarkerFeedback) -> None:
        """Call the function of the chosen entry."""
        entry = self._entries.get(feedback.menu_entry_id)
        if entry is not None and entry.callback is not None:
            entry.callback(feedback)

    def _messages(self, handles: list[int], parent: int) -> list[MenuEntry]:
        """Return the visible entries, each followed by those below it."""
        found = []
        for handle in handles:
            entry = self._entries[handle]
            if entry.is_visible:
                made = MenuEntry(
                    id=handle,
                    parent_id=parent,
                    title=_MARKS[entry.check_state] + entry.title,
                    command=entry.command,
                    command_type=entry.command_type,
                )
                found += [made, *self._messages(entry.below, handle)]
        return found
