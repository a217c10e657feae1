"""Columns and rows of the four tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from teleopctl.cli.verbs.top.controllers import ControllerRow
from teleopctl.cli.verbs.top.log import LogLine
from teleopctl.cli.verbs.top.processes import NodeRow
from teleopctl.cli.verbs.top.table import (
    Column,
    Row,
    age_text,
    execution_time_text,
    percent_text,
    rate_text,
    size_text,
)
from teleopctl.cli.verbs.top.topics import HEAVY_TYPES, TopicRow

TITLES = {"nodes": "1 Nodes", "topics": "2 Topics", "controllers": "3 Controllers", "log": "4 Log"}

LEVELS = ((10, "DEBUG"), (20, "INFO"), (30, "WARN"), (40, "ERROR"))

_WIDE, _MIDDLE = 100, 70

COLUMNS: Mapping[str, tuple[str, Sequence[Column]]] = {
    "nodes": (
        "NODE",
        (
            Column("CPU %", 6),
            Column("MEMORY", 9),
            Column("PID", 8, 60),
            Column("PROCESS", 24, _WIDE, is_number=False),
        ),
    ),
    "topics": (
        "TOPIC",
        (
            Column("HZ", 7),
            Column("BANDWIDTH", 10, 48),
            Column("AGE", 8),
            Column("PUB", 3, _MIDDLE),
            Column("SUB", 3, _MIDDLE),
            Column("TYPE", 30, _WIDE, is_number=False),
        ),
    ),
    "controllers": (
        "CONTROLLER",
        (
            Column("STATE", 12, is_number=False),
            Column("HZ", 5, 50),
            Column("TIME", 7, 60),
            Column("MAX", 7, _MIDDLE),
            Column("TYPE", 26, 120, is_number=False),
            Column("MANAGER", 20, 90, is_number=False),
        ),
    ),
    "log": (
        "MESSAGE",
        (
            Column("TIME", 12, 80, is_number=False),
            Column("LEVEL", 5, is_number=False),
            Column("NODE", 20, 60, is_number=False),
        ),
    ),
}

_STATE_STYLES = {"active": "green", "inactive": "cyan", "unconfigured": "yellow"}
_LEVEL_STYLES = {10: "dim", 20: "", 30: "yellow", 40: "red", 50: "bold red"}
_LEVEL_NAMES = {**dict(LEVELS), 50: "FATAL"}


def node_rows(nodes: Mapping[str, NodeRow], *, by_load: bool) -> list[Row]:
    """Return table rows by load, or by name with the processes without nodes last."""

    def place(item: tuple[str, NodeRow]) -> tuple[object, ...]:
        row = item[1]
        return (-(row.cpu_percent or 0.0) if by_load else not row.is_node, row.name, row.pid or 0)

    return [
        Row(
            key,
            row.name if row.is_node else f"({row.name})",
            (
                percent_text(row.cpu_percent),
                size_text(row.memory),
                str(row.pid or ""),
                row.running.qualified_name if row.running else "",
            ),
        )
        for key, row in sorted(nodes.items(), key=place)
    ]


def topic_rows(topics: Iterable[TopicRow], *, by_load: bool) -> list[Row]:
    """Return table rows of topics, sorted by name or by bandwidth."""
    ordered = sorted(topics, key=lambda t: (-t.bytes_per_s if by_load else 0.0, t.name))
    return [
        Row(
            topic.name,
            topic.name,
            (*_numbers(topic), str(topic.publishers), str(topic.subscriptions), topic.type_name),
            "" if topic.publishers else "dim",
        )
        for topic in ordered
    ]


def controller_rows(controllers: Iterable[ControllerRow]) -> list[Row]:
    """Return table rows of controllers, in the given order."""
    return [
        Row(
            f"{c.manager} {c.name}",
            c.name,
            (
                c.state,
                str(c.update_rate or ""),
                execution_time_text(c.average_us),
                execution_time_text(c.longest_us),
                c.type_name,
                c.manager,
            ),
            _STATE_STYLES.get(c.state, ""),
        )
        for c in controllers
    ]


def log_rows(lines: Sequence[tuple[int, LogLine]]) -> list[Row]:
    """Return table rows of log messages, the newest first, each on one line."""
    return [
        Row(
            str(number),
            " ".join(line.text.split()),
            (line.time, _LEVEL_NAMES.get(line.level, str(line.level)), line.node),
            _LEVEL_STYLES.get(line.level, ""),
        )
        for number, line in reversed(lines)
    ]


def _numbers(topic: TopicRow) -> tuple[str, str, str]:
    if topic.traffic is None:
        return ("m: look", "", "") if topic.type_name in HEAVY_TYPES else ("", "", "")
    rate_hz, bytes_per_s, age_s = topic.traffic
    return rate_text(rate_hz), size_text(bytes_per_s, "/s"), age_text(age_s)
