"""How ``topic echo`` prints what arrives: each message, its information, what was lost."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.cli import console
from teleopctl.cli.verbs.topic.text import TextStyle, is_message, json_value

if TYPE_CHECKING:
    from teleopctl.cli.console import Json
    from teleopctl.node import MessageInfo

# Publishers whose numbers are remembered: more than any topic has; a stranger may make some up.
_MOST_SENDERS = 1000


class EchoText:
    """Prints messages in the chosen text style.

    Args:
        style: How values are written.
        fields: Paths of the fields to be printed; the whole message if there is none.
        form: ``yaml``, ``csv`` or ``json``.
        with_info: Print what is known of each message besides.
        names_topics: Print the topic of each message.
        clears: Clear the terminal before each message.
    """

    def __init__(
        self,
        style: TextStyle,
        fields: Sequence[str],
        form: str,
        *,
        with_info: bool,
        names_topics: bool,
        clears: bool,
    ) -> None:
        from teleopctl.interfaces import field_reader

        self._style = style
        self._fields = [(path, field_reader(path)) for path in fields]
        self._with_info = with_info
        self._names_topics = names_topics
        self._clears = clears and sys.stdout.isatty()
        self._write: Callable[[str, list[Any], MessageInfo], None] = {
            "yaml": self._write_yaml,
            "csv": self._write_csv,
            "json": self._write_json,
        }[form]

    # Any, here and below: messages of any type, and parts of them.
    def chosen(self, message: Any) -> list[Any]:
        """Return the selected fields of a message, or the message.

        Raises:
            InvalidMessageError: It has no such field.
        """
        return [read(message) for _, read in self._fields] or [message]

    def write(self, topic: str, values: list[Any], info: MessageInfo) -> None:
        """Print the selected values of a message."""
        if self._clears:
            console.clear_terminal()
        self._write(topic, values, info)
        console.flush()

    def _write_json(self, topic: str, values: list[Any], info: MessageInfo) -> None:
        documents = [json_value(value) for value in values]
        document: Json = documents[0]
        if len(documents) > 1:
            document = {path: each for (path, _), each in zip(self._fields, documents, strict=True)}
        if self._with_info or self._names_topics:
            document = {"message": document}
            if self._with_info:
                document = {"info": _shown(info), **document}
            if self._names_topics:
                document = {"topic": topic, **document}
        console.out_json(document, compact=True)

    def _write_csv(self, topic: str, values: list[Any], info: MessageInfo) -> None:
        columns = [topic] if self._names_topics else []
        if self._with_info:
            columns += map(str, _shown(info).values())
        console.out(",".join([*columns, *map(self._style.csv, values)]))

    def _write_yaml(self, topic: str, values: list[Any], info: MessageInfo) -> None:
        if self._names_topics:
            # A comment, so that what was printed can be read as YAML again.
            console.out(f"# {topic}")
        if self._with_info:
            console.out_lines(_info_lines(info, is_of_message=is_message(values[0])))
        console.out_text(f"{''.join(map(self._style.yaml, values))}---")


def _info_lines(info: MessageInfo, *, is_of_message: bool) -> list[str]:
    shown = _shown(info)
    if not is_of_message:
        return ["---Got new message, message info:---", str(shown), "---Message data:---"]
    lines = [f"{key}: {'null' if entry is None else entry}" for key, entry in sorted(shown.items())]
    return [*lines, "---"]


def _shown(info: MessageInfo) -> dict[str, int | None]:
    return {key: value for key, value in info.items() if isinstance(value, int | None)}


class LossReport:
    """Counts the gaps in publishers' sequence numbers and prints them, as ROS 2 does."""

    def __init__(self) -> None:
        self._last: dict[bytes, int] = {}
        self._lost = 0

    def note(self, info: MessageInfo) -> None:
        """Compare a message's sequence number with the last one."""
        publisher, number = info["publisher_gid"], info["publication_sequence_number"]
        last = self._last.pop(publisher, None)
        if len(self._last) >= _MOST_SENDERS:
            del self._last[next(iter(self._last))]
        self._last[publisher] = number
        gap = 0 if last is None else number - last - 1
        if gap > 0:
            self._lost += gap
            console.note(
                f"A message was lost!!!\n\ttotal count change:{gap}\n\ttotal count: {self._lost}---"
            )
