"""``teleopctl control top``: rates and execution times of controllers and hardware."""

import math
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any, NamedTuple
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.control.manager import ManagerOptions
from teleopctl.errors import NotFoundError, UsageError
from teleopctl.interfaces import get_message, to_nanoseconds

if TYPE_CHECKING:
    from teleopctl.control import ControllerManagerClient

# Statistics of a controller or of hardware, as ros2_control names them.
_TIME = "/execution_time/current_value"
_LONGEST = "/execution_time/max"
_COUNT = "/execution_time/sample_count"
# Numbers of missed cycles and of clamped commands, which ROS 2's manager does not publish.
_MISSED, _LIMITED = ".missed_cycles", ".stats/limited_commands"
_KINDS = ("cycle", "hardware", "controller")
_PARTS = {
    ".stats": ("controller", ""),
    ".stats/read_cycle": ("hardware", " read"),
    ".stats/write_cycle": ("hardware", " write"),
}
# The manager's time of a whole cycle, which has no count.
_CYCLE = ".total_time"
_US_PER_S = 1e6
_LEAST_S = 0.1


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

    Percentiles and overruns are of the updates that the manager reports in the window; the longest
    time is that since the activation. An overrun is an update that took longer than its period.
    MISSED are cycles that the manager's loop missed, LIMITED are clamped commands.
    """
    for flag, value in (("--window", window), ("--period", period)):
        if not _LEAST_S <= value < math.inf:
            raise UsageError(f"{flag} must be at least {_LEAST_S:g} s, not {value:g}")
    with manager.client() as client:
        watch = _Watch(client, window)
        is_screen = sys.stdout.isatty() and not as_json
        while True:
            watch.wait(window if once else period)
            rows = watch.rows()
            if as_json:
                console.out_json([row._asdict() for row in rows], compact=not once)
            else:
                if is_screen and not once:
                    console.clear_terminal()
                console.out_lines(table(rows, client.name))
            console.flush()
            if once:
                return


class UpdateTimes(NamedTuple):
    """Rate and execution times of a controller, of hardware or of the whole cycle.

    Attributes:
        name: Name of the controller, or of the hardware with ``read`` or ``write``.
        kind: ``controller``, ``hardware`` or ``cycle``.
        rate: Updates per second of the manager's clock; None if unknown.
        nominal_rate: Update rate that is set, in Hz; None if unknown.
        p50_us: Median of the execution times in the window, in µs; None without samples.
        p99_us: Their 99th percentile, in µs.
        max_us: Longest execution time since the activation, in µs; of the cycle, in the window.
        overruns: Number of samples that are longer than the nominal period.
        samples: Number of samples in the window.
        missed: Cycles that the manager's loop missed in the window; None of others.
        limited: Commands of a controller that were clamped to limits in the window; None of others.
    """

    name: str
    kind: str
    rate: float | None
    nominal_rate: float | None
    p50_us: float | None
    p99_us: float | None
    max_us: float | None
    overruns: int
    samples: int
    missed: int | None = None
    limited: int | None = None


def percentile(ordered: Sequence[float], share: float) -> float | None:
    """Return the smallest value that a share of ascending values does not exceed; None if empty.

    Nearest-rank method, which returns a value that was measured.
    """
    return ordered[max(0, math.ceil(share * len(ordered)) - 1)] if ordered else None


class _Samples:
    """Execution times of one controller, hardware or cycle within a window."""

    def __init__(self) -> None:
        # Time of arrival in s, stamp of the manager in ns, number of updates, duration in µs.
        self.kept: deque[tuple[float, int, float, float]] = deque()
        self.longest: float | None = None


class _Total:
    """Counter that the manager publishes, and its values within a window."""

    def __init__(self) -> None:
        # Time of arrival in s, value.
        self.kept: deque[tuple[float, float]] = deque()

    def since(self, begin_s: float) -> int:
        """Return by how much the counter has grown since a time; drop older values but one."""
        while len(self.kept) > 1 and self.kept[1][0] < begin_s:
            self.kept.popleft()
        return max(0, round(self.kept[-1][1] - self.kept[0][1]))


class StatisticsWindow:
    """Execution times from a controller manager's published statistics, of the last seconds.

    Args:
        window_s: Length of the window, in seconds.
        rates: Nominal rates in Hz by the names of controllers and hardware.
    """

    def __init__(self, window_s: float, rates: Mapping[str, float]) -> None:
        self.rates = rates
        self._window_s = window_s
        self._samples: dict[str, _Samples] = {}
        self._totals: dict[str, _Total] = {}

    def add(self, now_s: float, stamp_ns: int, values: Mapping[str, float]) -> None:
        """Add published statistics.

        Args:
            now_s: Time of arrival, in seconds.
            stamp_ns: Time of the statistics on the manager's clock.
            values: Values by name.
        """
        for name, value in values.items():
            if name.endswith(_TIME):
                work = name.removesuffix(_TIME)
                self._add(work, now_s, stamp_ns, values.get(f"{work}{_COUNT}", 0.0), value)
                self._samples[work].longest = values.get(f"{work}{_LONGEST}")
            elif name.endswith(_CYCLE):
                self._add(name, now_s, stamp_ns, float(stamp_ns), value)
            elif name.endswith((_MISSED, _LIMITED)):
                self._totals.setdefault(name, _Total()).kept.append((now_s, value))
        for name in [name for name in self._samples if f"{name}{_TIME}" not in values]:
            if name not in values:  # unloaded
                del self._samples[name]

    def _add(self, work: str, now_s: float, stamp_ns: int, count: float, value: float) -> None:
        samples = self._samples.setdefault(work, _Samples())
        kept = samples.kept
        if kept and count < kept[-1][2]:
            kept.clear()  # activated again, or the clock was reset
        # The same update as before, in a message that is sent more often than updates happen.
        if count > 0.0 and not (kept and count == kept[-1][2]):
            kept.append((now_s, stamp_ns, count, value))

    def rows(self, now_s: float) -> list[UpdateTimes]:
        """Return the cycle, then hardware, then controllers, in the order of the statistics."""
        rows = []
        for work, samples in self._samples.items():
            while samples.kept and samples.kept[0][0] < now_s - self._window_s:
                samples.kept.popleft()
            row = self._row(work, samples)
            missed, limited = (
                total.since(now_s - self._window_s) if total is not None else None
                for total in map(
                    self._totals.get, (f"{row.name}{_MISSED}", f"{row.name}{_LIMITED}")
                )
            )
            rows.append(row._replace(missed=missed, limited=limited if row.samples else None))
        return sorted(map(_with_rate(rows), rows), key=lambda row: _KINDS.index(row.kind))

    def _row(self, work: str, samples: _Samples) -> UpdateTimes:
        kept = samples.kept
        durations = sorted(sample[3] for sample in kept)
        name, kind, suffix, rate = work.removesuffix(_CYCLE), "cycle", "", None
        longest = durations[-1] if durations else None
        if not work.endswith(_CYCLE):
            name, _, part = work.rpartition(".stats")
            kind, suffix = _PARTS[f".stats{part}"]
            longest = samples.longest
            rate = 0.0
            if len(kept) > 1 and kept[-1][1] > kept[0][1]:
                rate = (kept[-1][2] - kept[0][2]) / (kept[-1][1] - kept[0][1]) * 1e9
        nominal = self.rates.get(name)
        limit = _US_PER_S / nominal if nominal else math.inf
        return UpdateTimes(
            f"{name}{suffix}",
            kind,
            rate,
            nominal,
            percentile(durations, 0.5),
            percentile(durations, 0.99),
            longest,
            sum(duration > limit for duration in durations),
            len(durations),
        )


def _with_rate(rows: Sequence[UpdateTimes]) -> Callable[[UpdateTimes], UpdateTimes]:
    """Return a function that gives a cycle the rate of hardware that is read in each cycle."""

    def completed(row: UpdateTimes) -> UpdateTimes:
        if row.kind != "cycle":
            return row
        every = (
            each.rate
            for each in rows
            if each.kind == "hardware" and each.nominal_rate == row.nominal_rate is not None
        )
        return row._replace(rate=next(every, None))

    return completed


_TITLES = (
    "RATE [Hz]",
    "SET",
    "P50 [us]",
    "P99 [us]",
    "MAX [us]",
    "OVERRUNS",
    "SAMPLES",
    "MISSED",
    "LIMITED",
)


def table(rows: Sequence[UpdateTimes], manager: str) -> Iterator[str]:
    """Yield the lines of a table of execution times, and one if no cycle runs.

    Args:
        rows: Rows of the table.
        manager: Full name of the controller manager.
    """
    width = max(len(name) for name in ("NAME", *(row.name for row in rows)))
    yield f"{'NAME':{width}}" + "".join(f"  {title:>9}" for title in _TITLES)
    for row in rows:
        cells = (
            _number(row.rate),
            "-" if row.nominal_rate is None else f"{row.nominal_rate:g}",
            *(_number(time_us) for time_us in (row.p50_us, row.p99_us, row.max_us)),
            str(row.overruns),
            str(row.samples),
            *("-" if count is None else str(count) for count in (row.missed, row.limited)),
        )
        yield f"{row.name:{width}}" + "".join(f"  {cell:>9}" for cell in cells)
    if not any(row.rate for row in rows):
        yield f"{manager} runs no cycles: `teleopctl control doctor` says why"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"


class _Watch:
    """Subscriptions to a manager's statistics.

    Raises:
        NotFoundError: The manager publishes no statistics.
    """

    def __init__(self, client: "ControllerManagerClient", window_s: float) -> None:
        self._client = client
        self._window = StatisticsWindow(window_s, {})
        self._names: dict[int, list[str]] = {}
        self._asked: Sequence[str] = ()
        self._lock = threading.Lock()
        topic = f"{client.name}/statistics"
        node = client.node
        if not node.graph().publishers(f"{topic}/values"):
            raise NotFoundError(
                f"{client.name} does not publish its statistics on {topic}/values",
                hint="Controller managers of ROS 2 Jazzy and later do.",
            )
        from teleopctl.node import qos_profile_latched

        # Names are sent when they change, values at each publication: small messages.
        node.create_subscription(
            get_message("pal_statistics_msgs/msg/StatisticsNames"),
            f"{topic}/names",
            self._take_names,
            qos_profile_latched,
            immediate=True,
        )
        node.create_subscription(
            get_message("pal_statistics_msgs/msg/StatisticsValues"),
            f"{topic}/values",
            self._take_values,
            100,
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
        """Return what was measured in the window; ask for nominal rates if names have changed."""
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
