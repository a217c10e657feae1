"""Planners by their names: OMPL's where it is installed, elsewhere one of our own."""

from __future__ import annotations

import re
from functools import cache
from importlib.util import find_spec

from teleopctl.errors import UnsupportedError, UsageError, did_you_mean
from teleopctl.kinematics.motion.planner import DEFAULT_PLANNER, OMPL, OWN, Planner

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


@cache
def has_ompl() -> bool:
    """Return whether OMPL's Python package is installed; it is not imported."""
    return find_spec("ompl") is not None


def planner_names(library: str = "") -> tuple[str, ...]:
    """Return the names of a library's planners; without a name, of the library in use."""
    library = library or (OMPL if has_ompl() else OWN)
    return OMPL_PLANNERS if library == OMPL else (DEFAULT_PLANNER,)


def choose_planner(name: str = "", library: str = "") -> tuple[Planner, tuple[str, ...]]:
    """Return the planner for a name, and its differences from the requested one, in sentences.

    Args:
        name: Name of the planner, as OMPL or MoveIt's configurations write it; empty for the
            default.
        library: ``ompl``, ``teleopctl``, or empty for OMPL where it is installed.

    Raises:
        UsageError: No planner of OMPL has the name.
        UnsupportedError: OMPL is requested, and not installed.
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


def planner_parameters(name: str = "", library: str = "") -> tuple[str, ...]:
    """Return the names of the parameters of a planner, such as ``range``.

    Args:
        name: As for `choose_planner`.
        library: As for `choose_planner`.

    Raises:
        UsageError: As `choose_planner`.
    """
    return choose_planner(name, library)[0].parameters
