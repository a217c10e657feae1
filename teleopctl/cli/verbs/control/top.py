"""``teleopctl control top``: rates and execution times of controllers and hardware."""

import math
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any, NamedTuple
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.control.execution_times import (
    HistogramWindow,
    StatisticsWindow,
    UpdateTimes,
)
from teleopctl.cli.verbs.control.manager import ManagerOptions, command_line
from teleopctl.errors import NotFoundError, UnavailableError, UsageError
from teleopctl.interfaces import get_message, to_nanoseconds

if TYPE_CHECKING:
    from teleopctl.control import ControllerManagerClient

_LEAST_S = 0.1
_ASKED_EVERY_S = 60.0
# A manager that has just started offers these a moment after its other services.
_OFFERED_WITHIN_S = 1.0


def top(
    window: Annotated[
        float, Option("--window", help="Seconds of the measurements shown.", metavar="S")
    ] = 5.0,
    period: Annotated[
        float, Option("--period", help="Seconds from one table to the next.", metavar="S")
    ] = 1.0,
    once: Annotated[
        bool, Option("-1", "--once", help="Measure for one window, print a table, and end.")
    ] = False,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """Watch rates and execution times of controllers and hardware until Ctrl-C.

    P50, P99 and MAX are of all updates in the window; of a manager of ROS 2, of those that it
    publishes. LONGEST is since the activation, or the manager's start. An overrun is an update that
    takes longer than its period. MISSED are cycles that the manager's loop missed, LIMITED are
    clamped commands. The period error is the difference between a cycle's period and the one that
    is set.
    """
    for flag, value in (("--window", window), ("--period", period)):
        if not _LEAST_S <= value < math.inf:
            raise UsageError(f"{flag} must be at least {_LEAST_S:g} s, not {value:g}")
    with manager.client() as client:
        watch, began_s = _watch(client, window), time.monotonic()
        is_screen = sys.stdout.isatty() and not as_json
        if once:
            console.note(f"Measuring {client.name} for {window:g} s")
        while True:
            watch.wait(window if once else period)
            rows = watch.rows()
            if as_json:
                console.out_json([row._asdict() for row in rows], compact=not once)
            else:
                width, height = shutil.get_terminal_size() if is_screen else (None, None)
                shown_s = min(window, time.monotonic() - began_s)
                lines = list(table(rows, client.name, shown_s, width))
                if once:
                    console.out_lines(lines)
                elif height:
                    console.clear_terminal()
                    console.out_lines(fitting_lines(lines, height - 1))
                else:
                    console.out_lines([*lines, ""])
            console.flush()
            if once:
                return


def fitting_lines(lines: Sequence[str], most: int) -> list[str]:
    """Return at most so many lines; the last one contains the number of omitted lines."""
    if len(lines) <= most:
        return list(lines)
    kept = max(0, most - 1)
    return [*lines[:kept], f"{len(lines) - kept} more: a higher terminal or --once shows them"]


class _Column(NamedTuple):
    """Column of the table: title, text of a row's cell, and rank among those left out first."""

    title: str
    cell: Callable[[UpdateTimes], str]
    left_out: int = 0


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"


def _count(value: int | None) -> str:
    return "-" if value is None else str(value)


def _rate(row: UpdateTimes) -> str:
    return _number(row.rate) if row.state in (None, "active") or row.rate else str(row.state)


_COLUMNS = (
    _Column("RATE", _rate),
    _Column("SET", lambda row: "-" if row.nominal_rate is None else f"{row.nominal_rate:g}", 2),
    _Column("P50", lambda row: _number(row.p50_us)),
    _Column("P99", lambda row: _number(row.p99_us)),
    _Column("MAX", lambda row: _number(row.max_us)),
    _Column("LONGEST", lambda row: _number(row.longest_us), 3),
    _Column("OVERRUNS", lambda row: _count(row.overruns), 6),
    _Column("MISSED", lambda row: _count(row.missed), 4),
    _Column("LIMITED", lambda row: _count(row.limited), 5),
    _Column("SAMPLES", lambda row: str(row.samples), 1),
)


def table(
    rows: Sequence[UpdateTimes], manager: str, window_s: float, width: int | None = None
) -> Iterator[str]:
    """Yield the lines of a table of execution times, and one if no cycle runs.

    Args:
        rows: Rows of the table.
        manager: Full name of the controller manager.
        window_s: Length of the measurements, in seconds.
        width: Most characters of a line, as far as columns can be left out; None for no limit.
    """
    yield f"{manager}, last {window_s:.1f} s: rates in Hz, times in us"
    names = ["NAME", *("  period error" if r.kind == "period error" else r.name for r in rows)]
    columns = {one: [one.title, *map(one.cell, rows)] for one in _COLUMNS}

    def lines() -> list[str]:
        first = [f"{name:{max(map(len, names))}}" for name in names]
        others = (
            [f"  {cell:>{max(map(len, cells))}}" for cell in cells] for cells in columns.values()
        )
        return list(map("".join, zip(first, *others, strict=True)))

    for one in sorted((one for one in _COLUMNS if one.left_out), key=lambda one: one.left_out):
        if width is None or len(lines()[0]) <= width:
            break
        del columns[one]
    yield from lines()
    if not any(row.samples for row in rows):
        yield f"{manager} runs no cycles: `{command_line(manager, 'doctor')}` says why"


def _watch(client: "ControllerManagerClient", window_s: float) -> "_Histograms | _Statistics":
    """Return the measurements of a manager: of all updates, or of those that it publishes.

    Raises:
        NotFoundError: The manager has neither.
    """
    topic = f"{client.name}/statistics"
    offered: list[bool] = []

    def is_offered() -> bool:
        graph = client.node.graph()
        offered[:] = [
            bool(graph.servers(f"{client.name}/get_execution_times")),
            bool(graph.publishers(f"{topic}/values")),
        ]
        return any(offered)

    if not client.node.context.wait_for_change(is_offered, _OFFERED_WITHIN_S):
        raise NotFoundError(
            f"{client.name} does not publish its statistics on {topic}/values",
            hint="Controller managers of ROS 2 Jazzy and later do.",
        )
    return _Histograms(client, window_s) if offered[0] else _Statistics(client, window_s)


class _Histograms:
    """Execution times from the histograms of a manager of teleopctl.

    Raises:
        UnavailableError: The manager has ended.
    """

    def __init__(self, client: "ControllerManagerClient", window_s: float) -> None:
        self._client = client
        self._window_s = window_s
        self._window = HistogramWindow(window_s)
        self._ask()

    def _ask(self) -> None:
        response = self._client.execution_times()
        if response is None:
            raise UnavailableError(
                f"{self._client.name} has ended", hint="`teleopctl ps` lists what runs."
            )
        self._window.add(time.monotonic(), response)

    def wait(self, seconds: float) -> None:
        """Wait; ask for the histograms at the begin and the end of the window."""
        for part_s in (seconds - self._window_s, min(seconds, self._window_s)):
            ends_s = time.monotonic() + part_s
            while (left_s := ends_s - time.monotonic()) > 0.0:
                # The manager ends the counting some minutes after the last request.
                time.sleep(min(left_s, _ASKED_EVERY_S))
                self._ask()

    def rows(self) -> list[UpdateTimes]:
        """Return the measured rows of the window."""
        return self._window.rows()


class _Statistics:
    """Execution times from the statistics that a manager of ROS 2 publishes."""

    def __init__(self, client: "ControllerManagerClient", window_s: float) -> None:
        self._client = client
        self._window = StatisticsWindow(window_s, {})
        self._names: dict[int, list[str]] = {}
        self._asked: Sequence[str] = ()
        self._lock = threading.Lock()
        from teleopctl.node import qos_profile_latched

        # Names are sent when they change, values at each publication: small messages.
        for name, kind, take, qos in (
            ("names", "StatisticsNames", self._take_names, qos_profile_latched),
            ("values", "StatisticsValues", self._take_values, 100),
        ):
            client.node.create_subscription(
                get_message(f"pal_statistics_msgs/msg/{kind}"),
                f"{client.name}/statistics/{name}",
                take,
                qos,
                immediate=True,
            )

    # Any, here and below: messages, whose classes are generated at run time.
    def _take_names(self, message: Any) -> None:
        with self._lock:
            self._names = {message.names_version: list(message.names)}

    def _take_values(self, message: Any) -> None:
        with self._lock:
            names = self._names.get(message.names_version)
            if names is not None and len(names) == len(message.values):
                values = dict(zip(names, message.values, strict=True))
                stamp_ns = to_nanoseconds(message.header.stamp)
                self._window.add(time.monotonic(), stamp_ns, values)

    def wait(self, seconds: float) -> None:
        """Wait while measurements arrive."""
        time.sleep(seconds)

    def rows(self) -> list[UpdateTimes]:
        """Return the measured rows of the window; request nominal rates if names have changed."""
        with self._lock:
            names = next(iter(self._names.values()), [])
        if names != self._asked:
            self._asked, rates = names, self._nominal_rates()
            with self._lock:
                self._window.rates = rates
        with self._lock:
            return self._window.rows(time.monotonic())

    def _nominal_rates(self) -> dict[str, float]:
        client = self._client
        rates = {each.name: float(each.update_rate) for each in client.list_controllers()}
        there = client.call("list_hardware_components", "ListHardwareComponents").component
        hardware = {each.name: float(each.rw_rate) for each in there if each.rw_rate}
        cycle = {client.name.rpartition("/")[2]: max(hardware.values())} if hardware else {}
        return {**cycle, **hardware, **rates}
