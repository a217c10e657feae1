"""Links that overlap at the start: their contacts are disabled until they have come apart."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import mujoco
import numpy as np
import numpy.typing as npt

# Shapes nearer than this are not apart, such as those that touch in a plane: above rounding errors,
# and too small to be seen.
_APART_M = 1e-4

# Sorts after every pair of bodies, whose indices fill sixteen bits each, and is no pair itself.
_NO_PAIR = 2**31 - 1


class InitialOverlaps:
    """Pairs of links, given as overlapping at the start, whose contacts are enabled once they part.

    Each `check` tests one pair, in turn, so that its cost does not grow with the robot. The
    contacts of shapes that never part stay disabled.

    Args:
        model: The ``mujoco.MjModel``, whose excluded pairs are changed.
        data: Its ``mujoco.MjData``.
        pairs: Names of the links that overlap at the start; the model excludes all these pairs.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, pairs: Sequence[tuple[str, str]]
    ) -> None:
        self._m, self._d = model, data
        self._names = tuple(pairs)
        self._excluded = np.array(model.exclude_signature)
        self._pairs = [_Pair(model, first, second) for first, second in pairs]
        self._waiting: deque[_Pair] = deque()

    def reset(self) -> None:
        """Disable the contacts of all pairs, as at the start of the simulation."""
        self._waiting = deque(self._pairs)
        self._m.exclude_signature[:] = self._excluded

    def save(self) -> npt.NDArray[np.float64]:
        """Return the indices of the pairs whose contacts are still disabled, in checking order."""
        return np.array([self._pairs.index(pair) for pair in self._waiting], float)

    def restore(self, waiting: npt.NDArray[np.float64]) -> None:
        """Set which pairs have disabled contacts, by the indices that `save` returned."""
        self.reset()
        numbers = dict.fromkeys(int(number) for number in waiting)
        self._waiting = deque(self._pairs[n] for n in numbers if 0 <= n < len(self._pairs))
        for number, pair in enumerate(self._pairs):
            if number not in numbers:
                self._release(pair)

    @property
    def waits(self) -> bool:
        """Whether any pair still has disabled contacts."""
        return bool(self._waiting)

    def transferred_to(self, model: mujoco.MjModel, data: mujoco.MjData) -> InitialOverlaps:
        """Return a copy of these pairs, with their state, for another compiled model of the robot.

        Args:
            model: The other ``mujoco.MjModel``, whose excluded pairs are changed.
            data: Its ``mujoco.MjData``.
        """
        moved = InitialOverlaps(model, data, self._names)
        waiting = {pair.names: None for pair in self._waiting}
        for pair in moved._pairs:
            if pair.names not in waiting:
                moved._release(pair)
        # In the order in which they are checked.
        by_name = {pair.names: pair for pair in moved._pairs}
        moved._waiting = deque(by_name[names] for names in waiting)
        return moved

    def check(self) -> None:
        """Check the next pair in turn, and enable its contacts if its shapes are apart."""
        # The shapes' present poses: those in the data may be a physics step old.
        mujoco.mj_kinematics(self._m, self._d)
        pair = self._waiting.popleft()
        if pair.overlaps(self._m, self._d):
            self._waiting.append(pair)
        else:
            self._release(pair)

    def _release(self, pair: _Pair) -> None:
        # MuJoCo scans its list once: the list must stay sorted and keep its length.
        listed = self._m.exclude_signature
        listed[listed == pair.signature] = _NO_PAIR
        listed.sort()


class _Pair:
    """Two links with MuJoCo's signature of the pair, and the pairs of their shapes."""

    def __init__(self, model: mujoco.MjModel, first: str, second: str) -> None:
        self.names = first, second
        low, high = sorted(int(model.body(name).id) for name in (first, second))
        self.signature = (low << 16) + high
        # Shapes that overlapped the last time come first: mostly one distance is then enough.
        self._geoms = [
            (one, other)
            for one in _geoms(model, low)
            for other in _geoms(model, high)
            if model.geom_contype[one] & model.geom_conaffinity[other]
            or model.geom_contype[other] & model.geom_conaffinity[one]
        ]

    def overlaps(self, model: mujoco.MjModel, data: mujoco.MjData) -> bool:
        """Return whether any two shapes of the pair are closer than 0.1 mm."""
        for number, (one, other) in enumerate(self._geoms):
            # MuJoCo returns the given maximum for all longer distances.
            if mujoco.mj_geomDistance(model, data, one, other, _APART_M, None) < _APART_M:
                self._geoms.insert(0, self._geoms.pop(number))
                return True
        return False


def _geoms(model: mujoco.MjModel, body: int) -> range:
    first = int(model.body_geomadr[body])
    return range(first, first + int(model.body_geomnum[body]))
