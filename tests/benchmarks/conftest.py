"""Fixtures of the benchmarks; print a table of all figures, with date, machine and aims."""

from __future__ import annotations

import datetime
import io
import os
import platform
from importlib.metadata import version
from pathlib import Path

import pytest
from rich import box
from rich.console import Console
from rich.table import Table

from tests.benchmarks.figure import Figure

ROOT = Path(__file__).parents[2]
LIBRARIES = ("eclipse-zenoh", "mujoco", "numpy")


_FIGURES = pytest.StashKey[dict[str, list[Figure]]]()


@pytest.fixture
def figures(request: pytest.FixtureRequest) -> list[Figure]:
    """Fixture: figures of the benchmark's file; an appended `Figure` is a row of the table."""
    return request.config.stash[_FIGURES].setdefault(request.path.stem, [])


@pytest.fixture(autouse=True)
def _processes_find_the_benchmarks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Set PYTHONPATH so that ``python -m tests.benchmarks.…`` works in any folder."""
    path = os.environ.get("PYTHONPATH")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), *([path] if path else [])]))


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_FIGURES] = {}


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    figures = config.stash[_FIGURES]
    if not figures:
        return
    now = datetime.datetime.now().astimezone()
    libraries = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    terminalreporter.write_line("")
    terminalreporter.write_line(
        f"{now:%Y-%m-%d %H:%M}, {platform.system()} {platform.machine()}, {_processor()}, "
        f"{os.cpu_count()} cores, Python {platform.python_version()}, {libraries}"
    )
    table = Table("subject", "result", "floor", "ratio", "aim", box=box.ASCII2)
    for file, rows in figures.items():
        table.add_section()
        table.add_row(file.removeprefix("test_").replace("_", " "))
        for row in rows:
            ratio = "" if row.ratio is None else f"{row.ratio:.2f}"
            aim = "" if row.aim is None else f"{row.aim:g}"
            is_missed = row.ratio is not None and row.aim is not None and row.ratio > row.aim
            table.add_row(f"  {row.subject}", row.result, row.floor, ratio + "!" * is_missed, aim)
    console = Console(width=160, no_color=True, file=io.StringIO())
    with console.capture() as text:
        console.print(table)
    terminalreporter.write_line(text.get())
    terminalreporter.write_line("A ratio with ! is above its aim.")


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or "unknown processor"
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else "unknown processor"
