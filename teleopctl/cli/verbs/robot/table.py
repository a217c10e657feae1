"""Many robots as a table."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from teleopctl.nodes.checking.report import RobotReport

_TITLES = ("FILE", "PARSES", "COMPILES", "STANDS", "MOVES", "BY", "FRAMES", "WHY NOT")


def table(reports: "Sequence[RobotReport]") -> "Iterator[str]":
    """Yield a table with a line per robot, and totals.

    Args:
        reports: What is known of them.
    """
    rows = [_TITLES, *(_row(report) for report in reports)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(_TITLES) - 1)]
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=False)]
        yield "  ".join([*cells, row[-1]]).rstrip()
    own = [row for row in rows if row[5] == "own"]
    if any(report.trial for report in reports):
        complete = sum(1 for report in reports if report.frames and not report.frames.missing)
        yield (
            f"{_yes(rows, 1)} parse, {_yes(rows, 2)} compile, {_yes(rows, 3)} stand, "
            f"{_yes(own, 4)} of {len(own)} with controllers of their own move by them, "
            f"{complete} have every frame"
        )
    failed = sum(1 for report in reports if report.fault)
    yield f"{len(reports) - failed} of {len(reports)} robots are fine"


def _yes(rows: "Sequence[tuple[str, ...]]", column: int) -> int:
    return sum(row[column] == "yes" for row in rows)


def _row(report: "RobotReport") -> tuple[str, ...]:
    trial, driven, frames = report.trial, report.driven, report.frames
    return (
        str(report.file),
        "no" if report.error else "yes",
        "-" if report.error else "no" if report.refusal else "yes",
        "-" if trial is None else "yes" if trial.verdict == "stands" else trial.verdict,
        "-" if driven is None else driven.verdict,
        "-" if driven is None else "own" if driven.own else "made",
        "-" if frames is None else f"{frames.links - len(frames.missing)}/{frames.links}",
        report.fault,
    )
