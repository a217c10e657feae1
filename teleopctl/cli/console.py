"""Output of the command line: data to stdout, notes, warnings and errors to stderr.

Data is plain text. Control characters in received text are made visible, see
`teleopctl.base.printable`. Rich is not used, since its import takes longer than most verbs run.
"""

from __future__ import annotations

import os
import sys

from teleopctl.base.printable import (
    printable_json,
    printable_line,
    printable_log,
    printable_text,
)
from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.errors import TeleopctlError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from typing import TextIO

    Json = Mapping[str, "Json"] | Sequence["Json"] | str | int | float | bool | None
else:
    Json = object


def _program() -> str:
    """Return the name by which the user started the program: teleopctl, or ros2."""
    name = os.path.basename(sys.argv[0] if sys.argv else "")  # noqa: PTH119 -- no Path at start-up
    return "ros2" if name.partition(".")[0] == "ros2" else "teleopctl"


PROGRAM = _program()
"""Name of the program in usage lines and messages."""
COMPLETION_VARIABLE = "_TELEOPCTL_COMPLETE"
"""Environment variable that a shell's completion script sets to request candidates."""

_BOLD_RED = "\x1b[1;31m"
_YELLOW = "\x1b[33m"
_RESET = "\x1b[0m"


def out(line: str = "") -> None:
    """Write one line to stdout, with control characters made visible."""
    sys.stdout.write(printable_line(line) + "\n")


def out_coloured(*parts: tuple[str, str]) -> None:
    """Write a line to stdout from pairs of text and colour; without colours if disabled.

    A colour is a terminal escape sequence, or empty; left out if colours are disabled.
    """
    is_coloured = colour_enabled(sys.stdout)
    for text, colour in parts:
        shown = printable_line(text)
        sys.stdout.write(f"{colour}{shown}{_RESET}" if colour and is_coloured else shown)
    sys.stdout.write("\n")


def out_lines(lines: Iterable[str]) -> None:
    """Write several lines to stdout in a single write."""
    sys.stdout.write("".join(printable_line(line) + "\n" for line in lines))


def out_text(text: str) -> None:
    """Write a text of one or more lines to stdout, with a line break added at its end."""
    sys.stdout.write(printable_text(text) + "\n")


def out_drawing(text: str) -> None:
    """Write a drawing to stdout; its colours stay, other control characters are made visible."""
    sys.stdout.write(printable_log(text) + "\n")


def clear_terminal() -> None:
    """Write to stdout the escape sequences that clear a terminal, and put the cursor at its top."""
    sys.stdout.write("\x1b[H\x1b[2J")


def flush() -> None:
    """Flush stdout; streaming verbs do so after each message."""
    sys.stdout.flush()


def out_json(document: Json, *, compact: bool = False) -> None:
    """Write one JSON document to stdout, indented or on one line.

    Args:
        document: Document to write.
        compact: Whether to write one line, for a verb that writes a document per message.
    """
    import json

    text = json.dumps(document, ensure_ascii=False, indent=None if compact else 2)
    sys.stdout.write(printable_json(text) + "\n")


def out_done(text: str, /, *, as_json: bool, **document: Json) -> None:
    """Print a verb's result: ``text`` for people, or the keyword arguments as a JSON object."""
    if as_json:
        out_json(document)
    else:
        out_text(text)


def note(text: str) -> None:
    """Print a line about progress, or a remark, to stderr."""
    _note(printable_text(as_typed(text)))


def as_typed(text: str) -> str:
    """Return a text in which command lines have the name by which the program was started."""
    if PROGRAM == "teleopctl":
        return text
    for before in ("`", ": ", "or "):
        text = text.replace(f"{before}teleopctl ", f"{before}{PROGRAM} ")
    return text


def note_once(key: str, text: str) -> None:
    """Print a line to stderr once per user and ``key``, and only if stderr is a terminal.

    Args:
        key: Name of the file in the user's state folder that marks the line as printed.
        text: Line to print.
    """
    if not sys.stderr.isatty():
        return
    from teleopctl.base.folders import state_dir

    said = state_dir() / "said" / key
    try:
        said.parent.mkdir(parents=True, exist_ok=True)
        said.open("x").close()
    except OSError:  # the line was printed before, or the state folder is not writable
        return
    note(text)


def warn(text: str) -> None:
    """Write a warning to stderr."""
    _note(_coloured(f"WARNING: {printable_text(text)}", _YELLOW, sys.stderr))


def error(failure: TeleopctlError) -> None:
    """Write an error and its hint to stderr."""
    begin = _coloured(f"{PROGRAM}:", _BOLD_RED, sys.stderr)
    _note(f"{begin} {printable_text(failure.message)}")
    if failure.hint:
        note(f"  {failure.hint}")


def colour_enabled(stream: TextIO) -> bool:
    """Return whether to colour the output of ``stream``.

    ``NO_COLOR`` disables colours and ``FORCE_COLOR`` enables them; else only terminals have them.
    """
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    if os.name == "nt" and not os.environ.keys() & {"WT_SESSION", "TERM"}:
        return False  # the legacy console would print the escape sequences
    return stream.isatty() and os.environ.get("TERM") != "dumb"


def replace_missing_streams() -> None:
    """Replace stdout and stderr by the null device if they are closed (``>&-``)."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            # Stays open until the end. Not pathlib, which every command would have to import.
            nowhere = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123
            setattr(sys, name, nowhere)


def traceback() -> None:
    """Write the traceback of the current exception to stderr."""
    import traceback

    traceback.print_exc()


def tolerate_narrow_encodings() -> None:
    """Make stdout and stderr print ``?`` for characters that their encoding lacks."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure") and (stream.encoding or "").lower() != "utf-8":
            stream.reconfigure(errors="replace")


def _note(text: str) -> None:
    sys.stderr.write(text + "\n")
    sys.stderr.flush()


def _coloured(text: str, colour: str, stream: TextIO) -> str:
    return f"{colour}{text}{_RESET}" if colour_enabled(stream) else text
