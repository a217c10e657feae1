"""Planners: search of a path that is free, behind one interface, by OMPL's names.

OMPL's planners serve where OMPL is installed; elsewhere, or where it is asked for, a search by
several trees of our own does.
"""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.util import find_spec

import numpy as np

from teleopctl.errors import UnsupportedError, UsageError, did_you_mean
from teleopctl.kinematics.motion.edges import EdgeChecker
from teleopctl.kinematics.poses import Array

OMPL, OWN = "ompl", "teleopctl"
"""Names of the libraries of planners."""
DEFAULT_PLANNER = "RRTConnect"
OMPL_PLANNERS = (
    "AORRTC",
    "BFMT",
    "BITstar",
    "BKPIECE1",
    "FMT",
    "InformedRRTstar",
    "KPIECE1",
    "LBKPIECE1",
    "PRM",
    "PRMstar",
    "RRT",
    "RRTConnect",
    "RRTstar",
    "SORRTstar",
)
"""Planners of OMPL's Python package that need a state space alone."""
# Planners that MoveIt's configurations name, and OMPL's Python package has not.
_UNWRAPPED = (
    *("BiEST", "BiTRRT", "EST", "LBTRRT", "LazyPRM", "LazyPRMstar", "PDST", "ProjEST", "SBL"),
    *("SPARS", "SPARStwo", "STRIDE", "TRRT", "ABITstar", "AITstar", "EITstar", "CForest"),
    *("AnytimePathShortening", "RRTsharp", "RRTXstatic", "TrajOpt"),
)
# MoveIt's names of planner configurations: ``geometric::RRTConnect``, ``RRTConnectkConfigDefault``.
_DECORATION = re.compile(r"^geometric::|k?Config(?:Default)?$", re.IGNORECASE)


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
    def text(self) -> str:
        """Library and name of the planner, such as ``OMPL RRTConnect``."""
        return f"{'OMPL' if self.library == OMPL else self.library} {self.name}"


@cache
def has_ompl() -> bool:
    """Return whether OMPL's Python package is installed; it is not imported."""
    return find_spec("ompl") is not None


def planner_names(library: str = "") -> tuple[str, ...]:
    """Return the names of the planners of a library; without a name, of that which serves."""
    library = library or (OMPL if has_ompl() else OWN)
    return OMPL_PLANNERS if library == OMPL else (DEFAULT_PLANNER,)


def choose_planner(name: str = "", library: str = "") -> tuple[Planner, tuple[str, ...]]:
    """Return the planner for a name, and what differs from what was asked for, in sentences.

    Args:
        name: Name of the planner, as OMPL or MoveIt's configurations write it; empty for the
            default.
        library: ``ompl``, ``teleopctl``, or empty for OMPL where it is installed.

    Raises:
        UsageError: No planner of OMPL has the name.
        UnsupportedError: OMPL is asked for, and not installed.
    """
    if library not in ("", OMPL, OWN):
        raise UsageError(f"There is no library of planners '{library}'", hint=f"{OMPL} or {OWN}")
    if library == OMPL and not has_ompl():
        raise UnsupportedError(
            "OMPL is not installed",
            hint="pip install ompl (wheels for Linux and macOS, Python up to 3.13); or leave the "
            "library out",
        )
    bare = _DECORATION.sub("", name.strip())
    known = {each.lower(): each for each in (*OMPL_PLANNERS, *_UNWRAPPED)}
    wanted = known.get(bare.lower(), "") if bare else DEFAULT_PLANNER
    if not wanted:
        raise UsageError(
            f"There is no planner '{name}'",
            hint=did_you_mean(bare, known.values())
            or f"The planners are {', '.join(planner_names(library))}",
        )
    uses_ompl = library != OWN and has_ompl()
    available = planner_names(OMPL if uses_ompl else OWN)
    notes: tuple[str, ...] = ()
    if wanted not in available:
        where = "OMPL's Python package has no" if uses_ompl else "Without OMPL there is no"
        notes = (f"{where} {wanted}: {DEFAULT_PLANNER} is used",)
        wanted = DEFAULT_PLANNER
    if uses_ompl:
        from teleopctl.kinematics.motion.ompl_planner import OmplPlanner

        return OmplPlanner(wanted), notes
    from teleopctl.kinematics.motion.tree_planner import TreePlanner

    return TreePlanner(), notes


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
        UsageError: It is no finite number.
    """
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise UsageError(f"The parameter '{parameter}' of {planner} is {value!r}, and no number")
    return number
