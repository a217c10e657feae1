"""Interface of planners: search of a free path between states of a group's joints."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from teleopctl.errors import UsageError
from teleopctl.kinematics.motion.edges import EdgeChecker
from teleopctl.kinematics.poses import Array

OMPL, OWN = "ompl", "teleopctl"
"""Names of the libraries of planners."""
DEFAULT_PLANNER = "RRTConnect"
RANGE = 0.08
"""Longest edge of a search as part of the diagonal of the space.

With OMPL's own 0.2 the median search in a narrow passage took three times as long, and a tenth of
the searches in a narrower one failed; below 0.05 searches in a shelf become slower.
"""


@dataclass(frozen=True, slots=True)
class Query:
    """Search of a path from a state to one of several states, all of them free.

    Attributes:
        start: Start, (n,).
        goals: Goals, (g, n).
        lower: Smallest positions that are searched, (n,), finite.
        upper: Largest positions that are searched, (n,), finite.
        timeout_s: Time for the search, s.
        seed: Start of the random numbers.
        parameters: Parameters of the planner by OMPL's names, such as ``range``.
    """

    start: Array
    goals: Array
    lower: Array
    upper: Array
    timeout_s: float
    seed: int = 0
    parameters: Mapping[str, str] = field(default_factory=dict)


class Planner(ABC):
    """Search of a free path in the space of a group's joints.

    Attributes:
        name: Name of the planner, as OMPL names it.
        library: Name of the library.
    """

    name: str
    library: str

    @abstractmethod
    def search(self, edges: EdgeChecker, query: Query) -> Array | None:
        """Return the corners of a path, (m, n), or None if none was found in time.

        The result depends on the arguments only, for planners that end with the first path.
        """

    @property
    @abstractmethod
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters that a query may set, such as ``range``."""

    def check_parameter(self, name: str) -> None:
        """Check that a parameter exists.

        Raises:
            UsageError: The planner has no such parameter.
        """
        if name not in self.parameters:
            raise UsageError(
                f"The planner {self.text} has no parameter '{name}'",
                hint=f"It has {', '.join(self.parameters) or 'none'}",
            )

    @property
    def text(self) -> str:
        """Library and name of the planner, such as ``OMPL RRTConnect``."""
        return f"{'OMPL' if self.library == OMPL else self.library} {self.name}"


def search_bounds(edges: EdgeChecker, ends: Array) -> tuple[Array, Array]:
    """Return the smallest and largest positions, (n,), between which paths are searched.

    A joint without a limit may go half a turn beyond start and goals.

    Args:
        edges: The checker.
        ends: Start and goals, (1 + g, n).
    """
    kinematics = edges.kinematics
    lower = np.where(np.isfinite(kinematics.lower), kinematics.lower, ends.min(axis=0) - np.pi)
    upper = np.where(np.isfinite(kinematics.upper), kinematics.upper, ends.max(axis=0) + np.pi)
    # A start that lies a hair outside, by the noise of its measurement.
    return np.minimum(lower, ends.min(axis=0)), np.maximum(upper, ends.max(axis=0))


def number_of(planner: str, parameter: str, value: str) -> float:
    """Return the value of a planner's parameter as a number.

    Raises:
        UsageError: The value is no finite number.
    """
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise UsageError(f"The parameter '{parameter}' of {planner} is {value!r}, and no number")
    return number
