"""Panel of the messages on ``/rosout``, the newest first.

Messages are shown in blocks, each an element of the page, so that a new message sends one block.
"""

from __future__ import annotations

import datetime
import math
from collections import deque
from itertools import islice
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from teleopctl.base.printable import shortened
from teleopctl.errors import UsageError
from teleopctl.node import qos_profile_rosout_default
from teleopctl.viewer.client_tracker import click_mark
from teleopctl.viewer.html import escaped_html, escaped_html_lines
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.panels.plots.collected import CollectedSamples

if TYPE_CHECKING:
    from teleopctl.viewer.displays.base import Stage

MOST_LINES = 1000
"""Number of messages that the panel keeps."""

LINES_OF_A_BLOCK = 25
"""Number of messages per element of the page."""

_ALL = "(all)"
_LONGEST_TEXT = 2000
_LEVELS = {"Debug": 10, "Info": 20, "Warn": 30, "Error": 40, "Fatal": 50}
# Grey, blue, amber, red, magenta: distinct on a dark and on a light page.
_COLORS = {10: "#8a8f98", 20: "#3b8fd6", 30: "#e0a100", 40: "#e5484d", 50: "#d6409f"}
_A_DAY_S = 86_400
# Messages may be stamped a little later than the last recorded one was received.
_AFTER_END_S = 1.0

_LINE = (
    '<div style="border-left:3px solid {color};padding:1px 6px;margin:0 0 3px;'
    'font-size:12px;line-height:1.35;overflow-wrap:anywhere">'
    '<span style="opacity:.6" title="Show this moment in plots and bag"><span {mark}>{time}</span>'
    '</span> <b style="color:{color}">{node}</b><br>'
    '<span style="white-space:pre-wrap">{text}</span></div>'
)


class LogMessage(NamedTuple):
    """Message of ``/rosout``: time in seconds, severity, logger and text."""

    stamp_s: float
    level: int
    node: str
    text: str


class LogHistory:
    """The last messages of ``/rosout``, which the log panels of all browsers share.

    Args:
        stage: The viewer's node.

    Attributes:
        count: Number of messages that were received.
    """

    def __init__(self, stage: Stage) -> None:
        self.count = 0
        self._stage = stage
        self._shown: set[object] = set()
        self._lines: dict[LogMessage, None] = {}
        self._end: Any = None

    def begin(self, panel: object) -> None:
        """Subscribe for a panel; transient local publishers send their last messages again."""
        self._shown.add(panel)
        if self._end is None:
            self._end = self._stage.subscribe(
                "/rosout", "rcl_interfaces/msg/Log", self._take, qos_profile_rosout_default
            )

    def end(self, panel: object) -> None:
        """Unsubscribe if no other panel needs the messages."""
        self._shown.discard(panel)
        if not self._shown and self._end is not None:
            self._end()
            self._end = None

    def after(self, count: int) -> list[LogMessage]:
        """Return the messages after the first ones, sorted by time; the last thousand at most.

        After subscribing, the last messages are received node by node.

        Args:
            count: Number of the first ones.
        """
        new = min(self.count - count, len(self._lines))
        return sorted(islice(self._lines, len(self._lines) - new, None), key=_stamp)

    def _take(self, message: Any) -> None:
        line = LogMessage(
            message.stamp.sec + message.stamp.nanosec * 1e-9,
            message.level,
            message.name,
            message.msg,
        )
        if line not in self._lines:
            self._lines[line] = None
            self.count += 1
            if len(self._lines) > MOST_LINES:
                del self._lines[next(iter(self._lines))]


class LogPanel(Panel):
    """Panel of the messages on ``/rosout``, filtered by severity, logger and text."""

    title: ClassVar[str] = "Log"
    icon = "list-details"
    works_hidden = True
    is_per_browser = True

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._history = page.shared(LogHistory)
        self._taken = 0
        self._lines: deque[LogMessage] = deque(maxlen=MOST_LINES)
        self._nodes: set[str] = set()
        self._blocks: deque[_Block] = deque()
        self._blocks_made = 0
        self._wait_ticks = 0
        self._paused = False
        # Messages after this time are not shown, in seconds.
        self._until_s = math.inf
        recording = page.shared(CollectedSamples).recording
        # The time at which a played recording ends, in seconds.
        self._end_s = math.inf if recording is None else recording.end_s + _AFTER_END_S

    def build(self) -> None:
        """Add the filters, the buttons and the folder of messages."""
        self._level: Any = self.gui.add_dropdown(
            "Level", tuple(_LEVELS), initial_value="Info", hint="Lowest severity to show"
        )
        with self.gui.add_folder("Filter", expand_by_default=False):
            # A folder makes their fields as wide as that of the form below.
            with self.gui.add_folder(None):
                self._node: Any = self.gui.add_dropdown("Node", (_ALL,))
                self._text: Any = self.gui.add_text("Contains", "")
            with self.gui.add_form(None) as form:
                self._time: Any = self.gui.add_text(
                    "Jump to",
                    "",
                    hint="A time, such as 14:02:30, or seconds, then Enter; empty for the newest. "
                    "Plots and the bag jump there too.",
                )
            form.on_submit(self.page.on_node_thread(lambda event: self._jump(event.client_id)))
            # What the player and this page log is newer than the bag.
            self._newer: Any = self.gui.add_checkbox(
                "Of the player",
                False,
                visible=self._end_s < math.inf,
                hint="Also lines that are not in the bag: of its player and of this page",
            )
        for filter_of_lines in (self._level, self._node, self._text, self._newer):
            filter_of_lines.on_update(self.page.on_node_thread(lambda _event: self._show_all()))
        self.keep("level", self._level)
        self.keep("node", self._node, has_more=True)
        self.keep("contains", self._text)
        self.keep("player", self._newer)
        self._buttons: Any = self.gui.add_button_group("Lines", ("Pause", "Clear"))
        self._buttons.on_click(self.page.on_node_thread(self._pressed))
        self._note = self.gui.add_html("")
        self._place = self.gui.add_folder(None)
        self._show_note()

    def began(self) -> None:
        """Subscribe to ``/rosout``; called when the browser shows the page."""
        self._history.begin(self)

    def ended(self) -> None:
        """Unsubscribe from ``/rosout``, unless another browser shows it."""
        self._history.end(self)

    def tick(self) -> None:
        """Show new messages; after many, skip ticks until the browser has drawn them."""
        if self._wait_ticks:
            self._wait_ticks -= 1
        elif self._history.count > self._taken and not self._paused:
            new, self._taken = self._history.after(self._taken), self._history.count
            self._lines.extend(new)
            self._offer_nodes(new)
            shown = [line for line in new if self._is_wanted(line)]
            self._add(shown)
            self._wait_ticks = len(shown) // LINES_OF_A_BLOCK
            self._show_note()

    def _pressed(self, event: Any) -> None:
        if event.target.value == "Clear":
            self._lines.clear()
            self._taken = self._history.count
            self._show_all()
        else:
            self._paused = not self._paused
            self._buttons.options = ("Resume" if self._paused else "Pause", "Clear")
            self._show_note()

    # --- moments ------------------------------------------------------------------------------

    def show_of(self, name: str) -> None:
        """Show the messages of one node.

        Args:
            name: Full name of the node.
        """
        # The logger of /a/b is a.b.
        logger = name.strip("/").replace("/", ".")
        self._nodes.add(logger)
        self._node.options = (_ALL, *sorted(self._nodes))
        self._node.value = logger
        self._level.value = min(_LEVELS, key=lambda level: _LEVELS[level])
        self._show_all()

    # Any: viser's handle of a browser.
    def clicked(self, client: Any, what: str) -> None:
        """Show the moment of a clicked message in plots and bag.

        Args:
            client: viser's handle of the browser.
            what: Time of the message in seconds.
        """
        self.page.workspace.go_to(client.client_id, float(what))

    def _jump(self, client_id: int) -> None:
        text = self._time.value.strip()
        if not text:
            self._until_s = math.inf
        else:
            newest_s = self._lines[-1].stamp_s if self._lines else 0.0
            self._until_s = stamp_of(text, newest_s)
            self.page.workspace.go_to(client_id, self._until_s)
        self._show_all()

    def _offer_nodes(self, lines: list[LogMessage]) -> None:
        new = {line.node for line in lines} - self._nodes
        # Generated logger names must not fill the list.
        if new and len(self._nodes) < MOST_LINES:
            self._nodes |= new
            chosen = self._node.value
            self._node.options = (_ALL, *sorted({*self._nodes, chosen} - {_ALL}))
            self._node.value = chosen

    def _is_wanted(self, line: LogMessage) -> bool:
        return (
            line.level >= _LEVELS[self._level.value]
            and (self._node.value == _ALL or f"{line.node}.".startswith(f"{self._node.value}."))
            and line.stamp_s <= self._until_s
            and (line.stamp_s <= self._end_s or self._newer.value)
            and self._text.value.lower() in line.text.lower()
        )

    def _show_all(self) -> None:
        while self._blocks:
            self._blocks.pop().remove()
        self._add([line for line in self._lines if self._is_wanted(line)])
        self._show_note()

    def _add(self, lines: list[LogMessage]) -> None:
        start = 0
        while start < len(lines):
            if not self._blocks or self._blocks[0].room == 0:
                self._blocks_made += 1
                with self._place:
                    # Elements are sorted by this number: the newest block is first.
                    handle = self.gui.add_html("", order=-float(self._blocks_made))
                self._blocks.appendleft(_Block(handle))
            taken = lines[start : start + self._blocks[0].room]
            self._blocks[0].add(taken)
            start += len(taken)
        while (len(self._blocks) - 1) * LINES_OF_A_BLOCK >= MOST_LINES:
            self._blocks.pop().remove()

    def _show_note(self) -> None:
        shown = sum(block.count for block in self._blocks)
        note = f"{shown} of {len(self._lines)} lines" if self._lines else "No messages yet."
        if self._lines and self._node.value != _ALL:
            note = f"{note}, of {escaped_html(self._node.value)}"
        if self._paused:
            note = f"Paused. {note}"
        if self._until_s < math.inf:
            note = f"{note}, until {_time_text(self._until_s)}"
        content = f'<div style="padding:0 12px 6px;font-size:12px;opacity:.6">{note}</div>'
        if content != self._note.content:
            self._note.content = content


class _Block:
    """Element of the page with up to `LINES_OF_A_BLOCK` messages, the newest first."""

    def __init__(self, handle: Any) -> None:
        self._handle = handle
        self._lines: list[str] = []

    @property
    def count(self) -> int:
        """Number of messages in the block."""
        return len(self._lines)

    @property
    def room(self) -> int:
        """Number of messages that the block can still take."""
        return LINES_OF_A_BLOCK - len(self._lines)

    def add(self, lines: list[LogMessage]) -> None:
        """Add messages to the block, the oldest first, and send the block to the browsers."""
        self._lines += [_shown(line) for line in lines]
        body = "".join(reversed(self._lines))
        self._handle.content = f'<div style="padding:0 12px">{body}</div>'

    def remove(self) -> None:
        """Remove the block's element from the page."""
        self._handle.remove()


def _stamp(line: LogMessage) -> float:
    return line.stamp_s


def _shown(line: LogMessage) -> str:
    level = max((known for known in _COLORS if known <= line.level), default=10)
    return _LINE.format(
        color=_COLORS[level],
        time=_time_text(line.stamp_s),
        mark=click_mark("log", f"{line.stamp_s:.9f}"),
        node=escaped_html(line.node),
        text=escaped_html_lines(line.text, _LONGEST_TEXT),
    )


def stamp_of(text: str, newest_s: float) -> float:
    """Return the time that the user has typed, in seconds.

    Args:
        text: A time of day, such as ``14:02`` or ``14:02:30.5``, or seconds.
        newest_s: Time of the newest message: a time of day is the last one that is not after it,
            to the second.

    Raises:
        UsageError: The text is neither.
    """
    try:
        if ":" not in text:
            return float(text)
        newest = datetime.datetime.fromtimestamp(newest_s).astimezone()
        day_time = datetime.time.fromisoformat(text)
        found = datetime.datetime.combine(newest.date(), day_time, newest.tzinfo).timestamp()
    except (ValueError, OverflowError, OSError) as error:
        raise UsageError(
            f"{shortened(text)} is no time: type 14:02:30, or seconds such as 12.5"
        ) from error
    return found if found <= newest_s + 1.0 else found - _A_DAY_S


def _time_text(stamp_s: float) -> str:
    """Return the time of day, or seconds for a simulated time."""
    if stamp_s < _A_DAY_S:
        return f"{stamp_s:.3f} s"
    try:
        time = datetime.datetime.fromtimestamp(stamp_s).astimezone()
    except (ValueError, OverflowError, OSError):
        return f"{stamp_s:.3f} s"
    return f"{time:%H:%M:%S}.{time.microsecond // 1000:03d}"
