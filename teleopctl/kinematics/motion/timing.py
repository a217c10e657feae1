"""Timing of a joint path under limits of velocity, acceleration and jerk.

Along the path q(s) the joints' velocities are q' v and their accelerations q' u + q'' x, with the
speed v of the path parameter, its square x = v² and its acceleration u. With u constant between two
points of a grid, x changes linearly in s, and all limits are linear in (u, x). The fastest law goes
backward from rest at the end, for the largest x at each point from which the next one can be
reached, and then forward with the largest u. Source: Pham and Pham 2018 (TOPP-RA).

The result is smoothed by a moving average over a time T, which makes accelerations continuous: the
jerk becomes (a(t) - a(t - T)) / T. Averages keep all limits of velocity and acceleration.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from teleopctl.errors import UsageError
from teleopctl.kinematics.motion.limits import MotionLimits
from teleopctl.kinematics.motion.path import JointPath
from teleopctl.kinematics.poses import Array

MOST_POINTS = 100_000
"""Points of a motion at most."""

# Points of the grid on a whole path, on a curved piece and on a straight one, at least; and how
# often the interval beside a place of rest is halved.
_GRID, _CURVED, _STRAIGHT, _HALVINGS = 160, 16, 2, 6
# Time (s) at which limits are checked, and by which the average's window is chosen.
_CHECK_S = 0.001
# Times at most: those of 50 s.
_MOST_CHECKS = 50_000
# Relative excess over limits that is allowed for rounding.
_ROUNDING = 1e-9
# Windows (as parts of the longest) that are tried where the geometry is kept.
_WINDOWS = (0.0625, 0.125, 0.25, 0.375, 0.5, 0.75, 1.0, 1.5)
# How often a window is made wider for the sake of the polynomials between two points, by how much
# more than the jerk requires, and how often a motion is slowed.
_WIDENINGS, _WIDER, _SLOWINGS = 4, 1.03, 5
# Nodes and weights of Gauss' quadrature of degree 7 on [0, 1].
_NEAR, _FAR = (math.sqrt((3.0 + sign * 2.0 * math.sqrt(1.2)) / 7.0) for sign in (-1.0, 1.0))
_NODES = 0.5 + 0.5 * np.array((-_FAR, -_NEAR, _NEAR, _FAR))
_WEIGHTS = (18.0 + math.sqrt(30.0) * np.array((-1.0, 1.0, 1.0, -1.0))) / 72.0


class Points(NamedTuple):
    """Points of a motion of n joints.

    Attributes:
        times: Times, (k,), s.
        positions: Positions, (k, n), rad or m.
        velocities: Velocities, (k, n).
        accelerations: Accelerations, (k, n).
    """

    times: Array
    positions: Array
    velocities: Array
    accelerations: Array


class TimeLaw(Protocol):
    """Time parameterization of joint positions, from rest to rest."""

    @property
    def duration_s(self) -> float:
        """Duration, s."""
        ...

    def at(self, times: Array) -> tuple[Array, Array, Array]:
        """Return positions, velocities and accelerations at times, (k,), s; (k, n) each."""
        ...

    def rates(self, times: Array) -> tuple[Array, Array]:
        """Return velocities and accelerations at times, (k,), s; (k, n) each."""
        ...


@dataclass(frozen=True, slots=True)
class FastestLaw:
    """Fastest motion along a path under limits of velocity and acceleration.

    Attributes:
        path: The path.
        parameters: Path parameters of the grid, (N + 1,).
        times: Times at these, (N + 1,), s.
        speeds: Speeds of the path parameter at these, (N + 1,), 1/s.
        accelerations: Accelerations of the path parameter between them, (N,), 1/s².
    """

    path: JointPath
    parameters: Array
    times: Array
    speeds: Array
    accelerations: Array

    @property
    def duration_s(self) -> float:
        """Duration, s."""
        return float(self.times[-1])

    def parameter_at(self, times: Array) -> tuple[Array, Array, Array]:
        """Return path parameter, its speed and its acceleration at times, (k,) each.

        Before the begin and after the end the motion rests.
        """
        clipped = np.clip(times, 0.0, self.duration_s)
        place = np.searchsorted(self.times, clipped, side="right") - 1
        place = np.clip(place, 0, len(self.accelerations) - 1)
        since = clipped - self.times[place]
        speed, change = self.speeds[place], self.accelerations[place]
        rests = (times < 0.0) | (times >= self.duration_s)
        parameters = self.parameters[place] + since * (speed + 0.5 * since * change)
        return (
            np.clip(parameters, 0.0, self.path.length),
            np.where(rests, 0.0, speed + since * change),
            np.where(rests, 0.0, change),
        )

    def integral(self, times: Array) -> Array:
        """Return the integral of the path parameter from 0 to times, (k,), s."""
        whole = self.parameters[:-1] * np.diff(self.times)
        step = np.diff(self.times)
        whole = whole + step**2 * (self.speeds[:-1] / 2.0 + step * self.accelerations / 6.0)
        sums = np.concatenate(([0.0], np.cumsum(whole)))
        clipped = np.clip(times, 0.0, self.duration_s)
        place = np.searchsorted(self.times, clipped, side="right") - 1
        place = np.clip(place, 0, len(self.accelerations) - 1)
        since = clipped - self.times[place]
        part = since * self.parameters[place] + since**2 * (
            self.speeds[place] / 2.0 + since * self.accelerations[place] / 6.0
        )
        return np.asarray(sums[place] + part + (times - clipped).clip(0.0) * self.path.length)

    def at(self, times: Array) -> tuple[Array, Array, Array]:
        """Return positions, velocities and accelerations at times, (k,), s; (k, n) each."""
        return _along(self.path, *self.parameter_at(times))

    def rates(self, times: Array) -> tuple[Array, Array]:
        """Return velocities and accelerations at times, (k,), s; (k, n) each."""
        return self.at(times)[1:]


class AveragedLaw:
    """Moving average of a motion over a window of time: continuous accelerations, cut corners.

    Args:
        law: The motion.
        window_s: The window T, s, above 0; the duration grows by it.
    """

    def __init__(self, law: FastestLaw, window_s: float) -> None:
        self.law, self.window_s = law, window_s
        self._ends = law.path.positions(np.array([0.0, law.path.length]))
        parts = _integrals(law, law.times[:-1], law.times[1:])
        # Integral of the positions up to each point of the grid.
        self._sums = np.concatenate((np.zeros((1, parts.shape[1])), np.cumsum(parts, axis=0)))

    @property
    def duration_s(self) -> float:
        """Duration, s."""
        return self.law.duration_s + self.window_s

    def at(self, times: Array) -> tuple[Array, Array, Array]:
        """Return positions, velocities and accelerations at times, (k,), s; (k, n) each."""
        means = (self._integral(times) - self._integral(times - self.window_s)) / self.window_s
        # Exactly at rest at the ends.
        means = np.where((times >= self.duration_s)[:, None], self._ends[1], means)
        means = np.where((times <= 0.0)[:, None], self._ends[0], means)
        return means, *self.rates(times)

    def rates(self, times: Array) -> tuple[Array, Array]:
        """Return velocities and accelerations at times, (k,), s; (k, n) each."""
        now, velocities, _ = self.law.at(times)
        then, old_velocities, _ = self.law.at(times - self.window_s)
        return (now - then) / self.window_s, (velocities - old_velocities) / self.window_s

    def _integral(self, times: Array) -> Array:
        """Return the integral of the positions from 0 to times, (k, n)."""
        law = self.law
        clipped = np.clip(times, 0.0, law.duration_s)
        place = np.searchsorted(law.times, clipped, side="right") - 1
        place = np.clip(place, 0, len(law.times) - 2)
        inside = self._sums[place] + _integrals(law, law.times[place], clipped)
        resting = np.where((times < 0.0)[:, None], *self._ends)
        outside = (times - clipped)[:, None] * resting
        return np.asarray(inside + outside)


@dataclass(frozen=True, slots=True)
class AveragedParameterLaw:
    """Motion on the same path as another one, with the moving average of its path parameter.

    Attributes:
        law: The motion.
        window_s: The window T, s, above 0; the duration grows by it.
    """

    law: FastestLaw
    window_s: float

    @property
    def duration_s(self) -> float:
        """Duration, s."""
        return self.law.duration_s + self.window_s

    def at(self, times: Array) -> tuple[Array, Array, Array]:
        """Return positions, velocities and accelerations at times, (k,), s; (k, n) each."""
        before, window = times - self.window_s, self.window_s
        now, speeds, _ = self.law.parameter_at(times)
        then, old_speeds, _ = self.law.parameter_at(before)
        parameters = (self.law.integral(times) - self.law.integral(before)) / window
        parameters = np.clip(parameters, 0.0, self.law.path.length)
        return _along(
            self.law.path, parameters, (now - then) / window, (speeds - old_speeds) / window
        )

    def rates(self, times: Array) -> tuple[Array, Array]:
        """Return velocities and accelerations at times, (k,), s; (k, n) each."""
        return self.at(times)[1:]


@dataclass(frozen=True, slots=True)
class SlowedLaw:
    """Motion along the path of another one, more slowly.

    Attributes:
        law: The motion.
        factor: Part by which it takes longer, at least 1.
    """

    law: TimeLaw
    factor: float

    @property
    def duration_s(self) -> float:
        """Duration, s."""
        return self.law.duration_s * self.factor

    def at(self, times: Array) -> tuple[Array, Array, Array]:
        """Return positions, velocities and accelerations at times, (k,), s; (k, n) each."""
        positions, velocities, accelerations = self.law.at(times / self.factor)
        return positions, velocities / self.factor, accelerations / self.factor**2

    def rates(self, times: Array) -> tuple[Array, Array]:
        """Return velocities and accelerations at times, (k,), s; (k, n) each."""
        velocities, accelerations = self.law.rates(times / self.factor)
        return velocities / self.factor, accelerations / self.factor**2


def fastest_law(path: JointPath, limits: MotionLimits) -> FastestLaw:
    """Return the fastest motion along a path, from rest to rest, without a limit of jerk."""
    parameters, pieces = _grid(path)
    squares = _squared_speeds(path, parameters, pieces, limits)
    speeds = np.sqrt(squares)
    steps = np.diff(parameters)
    times = 2.0 * steps / np.maximum(speeds[:-1] + speeds[1:], 1e-12)
    return FastestLaw(
        path,
        parameters,
        np.concatenate(([0.0], np.cumsum(times))),
        speeds,
        np.diff(squares) / (2.0 * steps),
    )


def smoothed_law(
    law: FastestLaw,
    limits: MotionLimits,
    *,
    keeps_path: bool = False,
    period_s: float = 0.01,
) -> TimeLaw:
    """Return a motion on the path of another one, also within the limits of jerk.

    A controller that interpolates between the points of the result by polynomials of degree 5
    keeps the limits as well.

    Args:
        law: The motion.
        limits: Limits of the joints.
        keeps_path: Whether the path is followed exactly, rather than with its corners cut by up to
            a T²/24 more.
        period_s: Time between the points that are sampled of the result, s.
    """
    if not np.isfinite(limits.jerks).any():
        return within_limits(law, limits)
    window_s = _window_s(law.rates(_check_times(law))[1], _check_step_s(law), limits)
    if window_s <= 0.0:
        return within_limits(law, limits)
    if keeps_path:
        best: TimeLaw | None = None
        for part in _WINDOWS:
            averaged = AveragedParameterLaw(law, part * window_s)
            if best is not None and averaged.duration_s >= best.duration_s:
                break
            found = within_limits(averaged, limits, period_s)
            if best is None or found.duration_s < best.duration_s:
                best = found
        assert best is not None
        return best
    smooth = AveragedLaw(law, window_s)
    for _ in range(_WIDENINGS):
        _, _, jerk = interpolated_excess(sampled(smooth, period_s), limits)
        if jerk <= 1.0:
            break
        # Where the jerk jumps between two points, a polynomial through them exceeds it.
        window_s *= _WIDER * jerk
        smooth = AveragedLaw(law, window_s)
    return within_limits(smooth, limits, period_s)


def within_limits(law: TimeLaw, limits: MotionLimits, period_s: float | None = None) -> TimeLaw:
    """Return a motion, slowed by the factor by which samples each 1 ms exceed its limits.

    Between the points of the grid speeds exceed by up to 0.4 %; the jerk of a fastest law does not
    count.

    Args:
        law: The motion.
        limits: Limits of the joints.
        period_s: Time between points between which a controller interpolates, s; None for none.
    """
    slowed, whole = law, 1.0
    for _ in range(_SLOWINGS):
        velocity, acceleration, jerk = excess(slowed, limits)
        if isinstance(law, FastestLaw):
            jerk = 0.0
        if period_s is not None:
            between = interpolated_excess(sampled(slowed, period_s), limits)
            velocity, acceleration, jerk = map(max, (velocity, acceleration, jerk), between)
        factor = max(velocity, math.sqrt(acceleration), math.cbrt(jerk))
        if factor <= 1.0 + _ROUNDING:
            break
        # The points are at other places of the motion then, so that it is looked at again.
        whole *= factor
        slowed = SlowedLaw(law, whole)
    return slowed


def sampled(law: TimeLaw, period_s: float) -> Points:
    """Return points of a motion at equal times, at most a period apart.

    Raises:
        UsageError: There are too many of them.
    """
    count = max(1, math.ceil(law.duration_s / period_s - 1e-6))
    if count > MOST_POINTS:
        raise UsageError(
            f"The motion takes {law.duration_s:.0f} s: {count} points, {period_s:g} s apart, are "
            f"more than {MOST_POINTS}",
            hint="Raise the scaling factors or the limits of the joints, or the time between the "
            "points.",
        )
    times = np.linspace(0.0, law.duration_s, count + 1)
    positions, velocities, accelerations = law.at(times)
    velocities[[0, -1]] = 0.0
    return Points(times, positions, velocities, accelerations)


def excess(law: TimeLaw, limits: MotionLimits) -> tuple[float, float, float]:
    """Return the largest velocity, acceleration and jerk as parts of their limits, each 1 ms."""
    times = _check_times(law)
    velocities, accelerations = law.rates(times)
    jerks = np.diff(accelerations, axis=0) / np.diff(times)[:, None]
    return _parts(velocities, accelerations, jerks, limits)


def interpolated_excess(points: Points, limits: MotionLimits) -> tuple[float, float, float]:
    """Return the largest velocity, acceleration and jerk as parts of their limits.

    Args:
        points: Points between which positions are interpolated by polynomials of degree 5, as
            ``joint_trajectory_controller`` does.
        limits: Limits of the joints.
    """
    h = np.diff(points.times)[:, None]
    v0, v1 = points.velocities[:-1], points.velocities[1:]
    a0, a1 = points.accelerations[:-1], points.accelerations[1:]
    # Position, velocity and acceleration that are missing at the end with c_3 to c_5 = 0.
    d = (np.diff(points.positions, axis=0) - h * (v0 + 0.5 * h * a0)) / h**3
    v = (v1 - v0 - h * a0) / h**2
    a = (a1 - a0) / h
    c3 = 10.0 * d - 4.0 * v + 0.5 * a
    c4 = (-15.0 * d + 7.0 * v - a) / h
    c5 = (6.0 * d - 3.0 * v + 0.5 * a) / h**2
    found = (0.0, 0.0, 0.0)
    for part in (0.0, 0.25, 0.5, 0.75, 1.0):
        t = part * h
        velocities = v0 + t * (a0 + t * (3.0 * c3 + t * (4.0 * c4 + 5.0 * t * c5)))
        accelerations = a0 + t * (6.0 * c3 + t * (12.0 * c4 + 20.0 * t * c5))
        jerks = 6.0 * c3 + t * (24.0 * c4 + 60.0 * t * c5)
        here = _parts(velocities, accelerations, jerks, limits)
        found = (max(found[0], here[0]), max(found[1], here[1]), max(found[2], here[2]))
    return found


def _parts(
    velocities: Array, accelerations: Array, jerks: Array, limits: MotionLimits
) -> tuple[float, float, float]:
    return (
        float((np.abs(velocities) / limits.velocities).max(initial=0.0)),
        float((np.abs(accelerations) / limits.accelerations).max(initial=0.0)),
        float((np.abs(jerks) / limits.jerks).max(initial=0.0)),
    )


def _check_times(law: TimeLaw) -> Array:
    step_s = _check_step_s(law)
    return np.arange(0.0, law.duration_s + step_s, step_s)


def _check_step_s(law: TimeLaw) -> float:
    """Return the sampling period: 1 ms, or more for a motion of minutes."""
    return max(_CHECK_S, law.duration_s / _MOST_CHECKS)


def _along(
    path: JointPath, parameters: Array, speeds: Array, changes: Array
) -> tuple[Array, Array, Array]:
    """Return positions, velocities and accelerations on a path, (k, n) each."""
    pieces = path.pieces(parameters)
    first, second = path.derivatives(parameters, pieces)
    return (
        path.positions(parameters, pieces),
        first * speeds[:, None],
        first * changes[:, None] + second * speeds[:, None] ** 2,
    )


def _integrals(law: FastestLaw, starts: Array, ends: Array) -> Array:
    """Return the integrals of the positions over parts of grid intervals, (k, n), s."""
    widths = ends - starts
    total = np.zeros((len(starts), law.path.coefficients.shape[2]))
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        parameters, _, _ = law.parameter_at(starts + node * widths)
        total += weight * law.path.positions(parameters)
    return np.asarray(total * widths[:, None])


def _window_s(accelerations: Array, step_s: float, limits: MotionLimits) -> float:
    """Return the shortest window, s, with which the average keeps the limits of jerk.

    Args:
        accelerations: Accelerations of the motion at equal times, (k, n).
        step_s: Time between them, s.
        limits: Limits of the joints.
    """
    peaks = np.abs(accelerations).max(axis=0, initial=0.0)
    longest = float((2.0 * peaks / limits.jerks).max(initial=0.0))
    low, high = 0, max(1, math.ceil(longest / step_s))
    if longest <= 0.0 or high > _MOST_CHECKS:
        return longest
    still = np.zeros((high + 1, accelerations.shape[1]))
    padded = np.concatenate((still, accelerations, still))
    while high - low > 1:
        middle = (low + high) // 2
        changes = np.abs(padded[middle:] - padded[:-middle])
        jerk = float((changes / (middle * step_s * limits.jerks)).max())
        low, high = (low, middle) if jerk <= 1.0 else (middle, high)
    return high * step_s


def _grid(path: JointPath) -> tuple[Array, npt.NDArray[np.intp]]:
    """Return path parameters, (N + 1,), and the piece of each interval between them, (N,).

    The intervals become shorter towards the places of rest, where the speed changes most.
    """
    widths = np.diff(path.breaks)
    is_curved = np.abs(path.coefficients[:, 2:]).max(axis=(1, 2), initial=0.0) > 0.0
    counts = np.ceil(_GRID * widths / path.length).astype(np.intp)
    # A spline has many pieces already.
    curved = max(2, min(_CURVED, 2 * _GRID // len(widths)))
    counts = np.maximum(counts, np.where(is_curved, curved, _STRAIGHT))
    pieces = np.repeat(np.arange(len(widths)), counts)
    first = np.concatenate(([0], np.cumsum(counts)[:-1]))
    part = (np.arange(len(pieces)) - first[pieces]) / counts[pieces]
    parameters = np.concatenate((path.breaks[pieces] + part * widths[pieces], path.breaks[-1:]))
    halves = 0.5 ** np.arange(1, _HALVINGS + 1)
    rests = np.array([0, *path.stops, len(widths)])
    after, before = rests[:-1], rests[1:] - 1
    added = [
        path.breaks[after][:, None] + np.multiply.outer(widths[after] / counts[after], halves),
        path.breaks[before + 1][:, None]
        - np.multiply.outer(widths[before] / counts[before], halves),
    ]
    parameters = np.sort(np.concatenate((parameters, *(each.ravel() for each in added))))
    return parameters, path.pieces(0.5 * (parameters[:-1] + parameters[1:]))


def _squared_speeds(
    path: JointPath, parameters: Array, pieces: npt.NDArray[np.intp], limits: MotionLimits
) -> Array:
    """Return the squared speeds of the fastest law at the points of a grid, (N + 1,).

    For each interval the limits of acceleration at both of its ends are rows |p u + r x| <= 1; with
    p > 0 they are -g - k x <= u <= g - k x, for g = 1/p and k = r/p. Any lower bound of u must be
    below any upper one, which bounds x.
    """
    starts, ends = parameters[:-1], parameters[1:]
    twice = 2.0 * (ends - starts)
    first, second = path.derivatives(starts, pieces)
    last, last_second = path.derivatives(ends, pieces)
    middle, _ = path.derivatives(0.5 * (starts + ends), pieces)
    # At the end of an interval x is x + 2 du, so that the row is (q' + 2 d q'') u + q'' x.
    p = np.hstack((first, last + twice[:, None] * last_second))
    r = np.hstack((second, last_second))
    scale = np.concatenate((limits.accelerations, limits.accelerations))
    p, r = p / scale, r / scale
    most = np.full(len(parameters), np.inf)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        is_flat = np.abs(p) <= 1e-9 * np.abs(p).max(initial=1e-300)
        alone = np.where(is_flat, 1.0 / np.abs(r), np.inf).min(axis=1)
        g = np.where(is_flat, np.inf, 1.0 / np.abs(p))
        k = np.where(is_flat, 0.0, r / p)
        # Velocities at the points, and half-way between them: x + d u below the bound.
        at_points = ((limits.velocities / np.vstack((first, last[-1:]))) ** 2).min(axis=1)
        at_ends = ((limits.velocities / last) ** 2).min(axis=1)
        half = ((limits.velocities / middle) ** 2).min(axis=1)
        most = np.minimum(most, at_points)
        most[1:] = np.minimum(most[1:], at_ends)
        # Pairs of a lower and an upper bound of u.
        difference = k[:, None, :] - k[:, :, None]
        pairs = np.where(difference > 0.0, (g[:, None, :] + g[:, :, None]) / difference, np.inf)
        bound = np.minimum(alone, pairs.min(axis=(1, 2)))
        # The next x is at least 0: u >= -x / 2d.
        rate = k - 1.0 / twice[:, None]
        bound = np.minimum(bound, np.where(rate > 0.0, g / rate, np.inf).min(axis=1))
        # The velocity half-way, with the lowest u: x + d u, u <= (h - x) / d.
        rate = 1.0 - 0.5 * twice[:, None] * k
        lowest = (half[:, None] + 0.5 * twice[:, None] * g) / rate
        bound = np.minimum(bound, np.where(rate > 0.0, lowest, np.inf).min(axis=1))
        most[:-1] = np.minimum(most[:-1], bound)
        # The next x, with the lowest u, is at most what can be controlled there.
        rate = 1.0 - twice[:, None] * k
        gain = np.where(rate > 0.0, 1.0 / rate, np.inf)
    most[[0, -1]] = 0.0
    for stop in path.stops:
        most[np.searchsorted(parameters, path.breaks[stop])] = 0.0
    offset = twice[:, None] * g
    offset[~np.isfinite(offset)] = 1e300
    controlled = most.tolist()
    x = 0.0
    for place in range(len(starts) - 1, -1, -1):
        reached = float(((x + offset[place]) * gain[place]).min())
        x = controlled[place] = min(controlled[place], reached)
    squares = [0.0]
    x = 0.0
    slope = twice[:, None] * k
    for place, bound_of_next in enumerate(controlled[1:]):
        fastest = x + float((offset[place] - slope[place] * x).min())
        fastest = min(fastest, 2.0 * float(half[place]) - x, bound_of_next)
        x = max(0.0, fastest)
        squares.append(x)
    return np.array(squares)
