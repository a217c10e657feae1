"""Why a controller manager refuses: its services answer with a bare no, its log has the cause."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from teleopctl.node import qos_profile_rosout_default

if TYPE_CHECKING:
    from teleopctl.viewer.page.page import Page

_ERROR = 40
_MOST = 50
# A no may overtake the log; ticks of a panel, ten a second.
_LONGEST_WAIT_TICKS = 5


class ManagerErrors:
    """Recent errors on /rosout, to explain failed calls of a controller manager.

    Args:
        page: Where to listen.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        self._errors: deque[tuple[int, str, str]] = deque(maxlen=_MOST)
        self._count = 0
        self._waiting: list[_Question] = []
        self._end: Callable[[], None] | None = None

    def begin(self) -> None:
        """Subscribe to /rosout."""
        self._end = self._page.stage.subscribe(
            "/rosout", "rcl_interfaces/msg/Log", self._take, qos_profile_rosout_default
        )

    def end(self) -> None:
        """Unsubscribe."""
        if self._end is not None:
            self._end()
            self._end = None
        self._waiting.clear()

    def now(self) -> int:
        """Return a mark for errors that are logged from here on."""
        return self._count

    def cause(self, nodes: Sequence[str], since: int, tell: Callable[[str | None], object]) -> None:
        """Look for the logged cause of a failure, and pass it to a callback.

        Args:
            nodes: Who may have said it, by full names.
            since: The mark from before the call, as `now` gives it.
            tell: Called with the text of the first error, or None if none comes.
        """
        self._waiting.append(
            _Question({name.strip("/").replace("/", ".") for name in nodes}, since, tell)
        )
        self._answer()

    def tick(self) -> None:
        """Give up on causes that have not been logged in time."""
        for question in self._waiting:
            question.ticks += 1
        self._answer()

    def _take(self, log: Any) -> None:
        if log.level >= _ERROR:
            self._count += 1
            self._errors.append((self._count, log.name, log.msg))
            self._answer()

    def _answer(self) -> None:
        for question in tuple(self._waiting):
            found = question.answer(self._errors)
            if found is not None or question.ticks >= _LONGEST_WAIT_TICKS:
                self._waiting.remove(question)
                question.tell(found)


class _Question:
    def __init__(self, loggers: set[str], since: int, tell: Callable[[str | None], object]) -> None:
        self._loggers = loggers
        self._since = since
        self.tell = tell
        self.ticks = 0

    def answer(self, errors: deque[tuple[int, str, str]]) -> str | None:
        for number, logger, text in errors:
            # A part of a node logs below the node's name.
            own = any(logger == name or logger.startswith(f"{name}.") for name in self._loggers)
            if number > self._since and own:
                return text
        return None
