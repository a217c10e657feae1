"""Planners of OMPL, with states and motions checked by an `EdgeChecker`."""

from __future__ import annotations

import atexit
import gc
import re
from collections.abc import Callable
from typing import Any

import numpy as np
from ompl import base, geometric, util

from teleopctl.errors import UsageError
from teleopctl.kinematics.motion.edges import EdgeChecker
from teleopctl.kinematics.motion.planner import OMPL, RANGE, Planner, Query, number_of
from teleopctl.kinematics.poses import Array

# What was frozen is not collected at Python's end, and nanobind would list OMPL's types as leaked.
atexit.register(gc.unfreeze)

# Setters of parameters, where a word of their names begins, and what takes no number.
_SETTER = re.compile(r"set[A-Z]")
_WORD = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
_OBJECTS = frozenset({"default_connection_strategy", "projection_evaluator"})


class OmplPlanner(Planner):
    """Planner of OMPL.

    Args:
        name: Name of its class in ``ompl.geometric``.
    """

    library = OMPL

    def __init__(self, name: str) -> None:
        self.name = name

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters that a query may set, such as ``range``."""
        own = getattr(geometric, self.name)
        setters = {name for name in dir(own) if _SETTER.match(name)} - set(dir(base.Planner))
        names = (_WORD.sub("_", name.removeprefix("set")).lower() for name in setters)
        return tuple(sorted({*names} - _OBJECTS))

    def search(self, edges: EdgeChecker, query: Query) -> Array | None:
        """Return the corners of a path, (m, n), or None if none was found in time."""
        util.noOutputHandler()
        information = _space_information(query)
        information.setStateValidityChecker(_state_validator(edges, len(query.start)))
        information.setMotionValidator(_MotionValidator(information, edges, len(query.start)))
        return self._solve(information, query)

    def _solve(self, information: Any, query: Query) -> Array | None:
        information.setup()
        count = len(query.start)

        def state(positions: Array) -> Any:
            allocated = information.allocState()
            allocated[0:count] = positions.tolist()
            return allocated

        # Each generator of random numbers that is made from here on has the next one's seed.
        util.RNG.setSeed(query.seed + 1)
        definition = base.ProblemDefinition(information)
        definition.addStartState(state(query.start))
        goals = base.GoalStates(information)
        for goal in query.goals:
            goals.addState(state(goal))
        definition.setGoal(goals)
        planner = getattr(geometric, self.name)(information)
        if hasattr(planner, "setRange"):
            planner.setRange(RANGE * float(np.linalg.norm(query.upper - query.lower)))
        for key, value in query.parameters.items():
            if key == "range" and number_of(self.name, key, value) == 0.0:
                # OMPL's word for its default; here for ours.
                continue
            self.check_parameter(key)
            _set_parameter(planner, self.name, key, value)
        planner.setProblemDefinition(definition)
        planner.setup()
        planner.solve(base.timedPlannerTerminationCondition(query.timeout_s))
        if not definition.hasExactSolution():
            return None
        states = definition.getSolutionPath().getStates()
        return np.array([state[0:count] for state in states], np.float64)


def _space_information(query: Query) -> Any:
    count = len(query.start)
    space = base.RealVectorStateSpace(count)
    bounds = base.RealVectorBounds(count)
    for place in range(count):
        bounds.setLow(place, float(query.lower[place]))
        bounds.setHigh(place, float(query.upper[place]))
    space.setBounds(bounds)
    return base.SpaceInformation(space)


def _state_validator(edges: EdgeChecker, count: int) -> Callable[[Any], bool]:
    return lambda state: edges.is_free(np.array(state[0:count]))


class _MotionValidator(base.MotionValidator):  # type: ignore[misc]
    """OMPL's check of a motion, by the edge checker of the present query."""

    def __init__(self, information: Any, edges: EdgeChecker, count: int) -> None:
        super().__init__(information)
        self._edges, self._count = edges, count

    # OMPL's name, and its third argument of planners that use a part of a motion.
    def checkMotion(self, start: Any, end: Any, _last: Any = None) -> bool:  # noqa: N802
        count, edges = self._count, self._edges
        last = np.array(end[0:count])
        return edges.is_free(last) and edges.is_edge_free(np.array(start[0:count]), last)


def _set_parameter(planner: Any, name: str, key: str, value: str) -> None:
    """Set a planner's parameter by OMPL's name, such as ``range`` or ``goal_bias``."""
    setters = {name.lower(): name for name in dir(planner)}
    setter = getattr(planner, setters[f"set{key.replace('_', '')}"])
    number = {"true": 1.0, "false": 0.0}.get(value.strip().lower())
    if number is None:
        number = number_of(name, key, value)
    # Which of them a setter takes is not known before.
    for kind in (float, int, bool):
        try:
            setter(kind(number))
        except (TypeError, ValueError):
            continue
        return
    raise UsageError(f"The planner {name} refuses {value!r} for its parameter '{key}'")
