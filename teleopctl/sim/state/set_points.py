"""How set-points of drives get from one position to the next, period by period of control.

All arrays have one number for each drive, (n,): rad or m, and seconds.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from teleopctl.sim.state.physics import Array

Flags = npt.NDArray[np.bool_]

# What part of the effort a set-point's acceleration may take on the way to a position that stands:
# the rest is for weight, for what other joints ask of this one, and for the spring to correct with.
# In periods that are long it is less: speeds change in steps, from one to the next.
_SHARE, _LONG_S = 0.5, 0.05

# Of a way that is just within reach, numbers are off by this part.
_NEARLY = 1.0 + 1e-6


def way_there(
    away: Array, before: Array, fresh: Flags, max_speed: Array, acceleration: Array, period_s: float
) -> Array:
    """Speeds of set-points on their way to a position.

    Straight to the next position of a path. On the way to one that stands or takes longer than a
    period, and where it starts from rest, it speeds up and brakes by no more than a part of the
    effort can do: it comes to rest at its end, however far that is.

    Args:
        away: How far the position is.
        before: The speeds in the period before.
        fresh: Whether the position is new in this period.
        max_speed: The joints' own.
        acceleration: What all of the joints' effort can do.
        period_s: The control period.
    """
    forth = np.maximum(before * np.sign(away), 0.0)
    follows = fresh & (forth > 0.0) & (np.abs(away) <= max_speed * period_s * _NEARLY)
    share = _SHARE * min(1.0, _LONG_S / period_s)
    more = np.where(follows, 1.0, share) * acceleration * period_s
    # In steps of one period, what is left after this one is enough to brake in. With x the last
    # term, it is more / 2 * (sqrt(1 + x) - 1) in a form that holds for any effort.
    straight = np.abs(away) / period_s
    braking = 4.0 * straight / (np.sqrt(1.0 + 8.0 * straight / more) + 1.0)
    most = np.minimum(np.minimum(straight, max_speed), forth + more)
    most = np.where(follows, most, np.minimum(most, braking))
    return np.copysign(most, away)


def fed_speed(
    speed: Array,
    within_reach: Flags,
    fed_before: Array,
    speeds_before: tuple[Array, Array],
    most_more: Array,
) -> Array:
    """What of a set-point's speed on the way to a position is fed forward.

    All of it where positions follow one another as a path, so that the joint does not lag. None
    towards a position that is not new or that takes more than a period: whoever asks for a jump
    wants to come to rest at its end, for which the damper has to see the joint's speed. Nor more
    than the periods before let expect: a path's first position may as well be a jump. In between,
    as much more in each period as the damper can answer with the joint's effort.

    Args:
        speed: Of the set-point in this period.
        within_reach: Whether the position is new, and reached in this period.
        fed_before: What was fed forward in the period before.
        speeds_before: The set-point's speeds in the two periods before, the last one first.
        most_more: The change of speed that the damper alone answers with all the joint's effort.
    """
    before = np.where(fed_before * speed > 0.0, fed_before, 0.0)
    more = np.clip(speed - before, -most_more, most_more)
    fed = np.where(np.abs(speed) > np.abs(before), before + more, speed)
    last, one_before = speeds_before
    expected = 2.0 * last - one_before
    fed = np.clip(fed, np.minimum(expected, 0.0), np.maximum(expected, 0.0))
    return np.where(within_reach, fed, 0.0)


def lost_distance(change: Array, lag_s: Array, acceleration: Array) -> Array:
    """How far a joint falls behind while it takes up another speed.

    It does so as a first-order system, or, where that asks for more than all of its effort, at the
    acceleration of that until the rest of the change is within it.

    Args:
        change: Of the speed.
        lag_s: The time constant.
        acceleration: What all of the joints' effort can do.
    """
    within = np.minimum(np.abs(change), acceleration * lag_s)
    beyond = np.abs(change) - within
    lost = within * lag_s + beyond * (beyond + 2.0 * within) / (2.0 * acceleration)
    return np.copysign(lost, change)
