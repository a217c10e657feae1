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

# Frozen objects are not collected at exit, and nanobind would list OMPL's types as leaked.
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
        checks = _Checks(edges, len(query.start))
        information.setStateValidityChecker(checks.is_valid)
        information.setMotionValidator(_MotionValidator(information, checks))
        return self._solve(information, query, checks)

    def _solve(self, information: Any, query: Query, checks: _Checks) -> Array | None:
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
                # OMPL's name for its default planner; here for ours.
                continue
            self.check_parameter(key)
            _set_parameter(planner, self.name, key, value)
        planner.setProblemDefinition(definition)
        planner.setup()
        checks.termination = base.timedPlannerTerminationCondition(query.timeout_s)
        planner.solve(checks.termination)
        checks.end()
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


class _Checks:
    """Checks of states and motions that OMPL calls.

    An exception must not pass through OMPL, some of whose planners have threads: it ends the search
    and is kept.

    Attributes:
        termination: OMPL's condition that ends the search.
        error: The exception of a check; None without one.
    """

    def __init__(self, edges: EdgeChecker, count: int) -> None:
        self._edges, self._count = edges, count
        self.termination: Any = None
        self.error: BaseException | None = None

    def is_valid(self, state: Any) -> bool:
        """Return whether a state is free."""
        return self._try(lambda: self._edges.is_free(np.array(state[0 : self._count])))

    def is_motion_valid(self, start: Any, end: Any) -> bool:
        """Return whether a straight motion is free."""
        edges, count = self._edges, self._count
        last = np.array(end[0:count])
        return self._try(
            lambda: edges.is_free(last) and edges.is_edge_free(np.array(start[0:count]), last)
        )

    def end(self) -> None:
        """End the use of the checks; raise the exception of one of them."""
        error, self.error, self.termination = self.error, None, None
        if error is not None:
            try:
                raise error
            finally:
                # Its traceback has this frame, and OMPL's objects must not be held by a circle.
                del error

    def _try(self, check: Callable[[], bool]) -> bool:
        if self.error is not None:
            return False
        try:
            return check()
        except BaseException as error:  # noqa: BLE001 - raised again after the search
            self.error = error
            if self.termination is not None:
                self.termination.terminate()
            return False


class _MotionValidator(base.MotionValidator):  # type: ignore[misc]
    """OMPL's check of a motion."""

    def __init__(self, information: Any, checks: _Checks) -> None:
        super().__init__(information)
        self._checks = checks

    # OMPL's name, and its third argument of planners that use a part of a motion.
    def checkMotion(self, start: Any, end: Any, _last: Any = None) -> bool:  # noqa: N802
        return self._checks.is_motion_valid(start, end)


def _set_parameter(planner: Any, name: str, key: str, value: str) -> None:
    """Set a planner's parameter by OMPL's name, such as ``range`` or ``goal_bias``."""
    setters = {name.lower(): name for name in dir(planner)}
    setter = getattr(planner, setters[f"set{key.replace('_', '')}"])
    number = {"true": 1.0, "false": 0.0}.get(value.strip().lower())
    if number is None:
        number = number_of(name, key, value)
    # Which of them a setter accepts depends on the planner.
    for kind in (float, int, bool):
        try:
            setter(kind(number))
        except (TypeError, ValueError):
            continue
        return
    raise UsageError(f"The planner {name} refuses {value!r} for its parameter '{key}'")
