"""``teleopctl ps``: the processes in the background."""

import sys
import time

from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Verb
from teleopctl.launch import Running, command_text, died, duration, running

VERB = Verb(f"{__name__}:ps", "List background processes.")

_HEADER = ("NAME", "PID", "KIND", "UPTIME", "COMMAND")
# Most characters of an argument that are printed; paths are shorter.
_LONGEST = 300


def ps(
    as_json: AsJson = False,
) -> int:
    """Print the background processes, and those that died and that ``stop`` has not reported.

    Processes of a launch are listed below it. Processes that died are listed until `teleopctl stop`
    has reported them, or their name is used again.
    """
    entries = _in_order([*running(), *died()])
    now = time.time()
    if as_json:
        console.out_json([_as_json(entry, now) for entry in entries])
        return 0
    if not entries:
        console.note("No background processes.")
        return 0
    rows = [_HEADER, *(_row(entry, now) for entry in entries)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(_HEADER) - 1)]
    limit = None
    if sys.stdout.isatty():
        from shutil import get_terminal_size

        limit = get_terminal_size().columns
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=False)]
        console.out("  ".join([*cells, row[-1]])[:limit].rstrip())
    return 0


def _in_order(entries: list[Running]) -> list[Running]:
    """Sort the processes of a launch after the launch, and those of an ended launch last."""
    places = {entry.record.pid: place for place, entry in enumerate(entries) if not entry.launch}

    def place(entry: Running) -> tuple[int, bool]:
        owner = entry.launch or entry.record
        return places.get(owner.pid, len(entries)), entry.launch is not None

    return sorted(entries, key=place)


def _row(entry: Running, now: float) -> tuple[str, ...]:
    record = entry.record
    return (
        f"  {record.name}" if entry.launch else record.name,
        str(record.pid),
        record.kind,
        entry.ending or duration(now - record.start.time).replace(" ", ""),
        command_text(map(_shortened, _without_python(record.command))),
    )


def _without_python(command: tuple[str, ...]) -> tuple[str, ...]:
    """Return a command without ``python -P -m``, which would fill most of the line."""
    _, *options = command
    return command[3:] if options[:2] == ["-P", "-m"] else command


def _shortened(argument: str) -> str:
    """Return an argument, a long one, such as a robot description, only with its beginning."""
    return argument if len(argument) <= _LONGEST else f"{argument[:_LONGEST]}…"


def _as_json(entry: Running, now: float) -> dict[str, console.Json]:
    record = entry.record
    return {
        "name": record.name,
        "pid": record.pid,
        "kind": record.kind,
        "launch": entry.launch.name if entry.launch else None,
        "node": entry.node_name,
        "start_time": record.start.time,
        "ending": entry.ending or None,
        "uptime_s": round(max(0.0, now - record.start.time), 3),
        "command": list(record.command),
        "log_file": str(record.log_file),
    }
