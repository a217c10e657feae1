"""A row of the table that the benchmarks print."""

from typing import NamedTuple


class Figure(NamedTuple):
    """A measured figure, as a row of the table.

    Attributes:
        subject: Command, message or model that was measured.
        result: Measured values with their units.
        floor: Measured values of the floor, the same work without teleopctl.
        ratio: Result divided by floor; None if the two are not comparable.
        aim: Highest acceptable ratio; None without an aim.
    """

    subject: str
    result: str
    floor: str = ""
    ratio: float | None = None
    aim: float | None = None
