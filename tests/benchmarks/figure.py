"""A row of the table that the benchmarks print."""

from typing import NamedTuple


class Figure(NamedTuple):
    """A measured figure, as a row of the table.

    Attributes:
        subject: Command, message or model that was measured.
        result: Its figures with their units.
        floor: The figures of the floor: the same work without teleopctl.
        ratio: Result divided by floor; None where they do not compare.
        aim: Highest ratio that is aimed at; None where none is set.
    """

    subject: str
    result: str
    floor: str = ""
    ratio: float | None = None
    aim: float | None = None
