"""Speeds of drives' set-points from one control period to the next.

Of one drive each; in rad or m, and seconds. Numbers, not arrays: for a dozen drives these take a
fifth of the time.
"""

from __future__ import annotations

from math import copysign, sqrt

# What part of the effort a set-point's acceleration may take on the way to a position that stands:
# the rest is for weight, for what other joints ask of this one, and for the spring to correct with.
# In periods that are long it is less: speeds change in steps, from one to the next.
_SHARE, _LONG_S = 0.5, 0.05

# The shortest time in which a joint on a velocity command brakes before its limits, in seconds:
# two time constants of its drive.
_BRAKING_S = 0.01

# Of a way that is just within reach, numbers are off by this part.
_NEARLY = 1.0 + 1e-6


def position_speed(
    away: float, before: float, fresh: bool, max_speed: float, acceleration: float, period_s: float
) -> float:
    """Return the set-point's speed for the next control period on its way to a position.

    Straight to the next position of a path. On the way to one that stands or takes longer than a
    period, and where it starts from rest, it speeds up and brakes by no more than a part of the
    effort can do: it comes to rest at its end, however far that is.

    Args:
        away: How far the position is.
        before: The speed in the period before.
        fresh: Whether the position is new in this period.
        max_speed: The joint's own.
        acceleration: What all of the joint's effort can do.
        period_s: The control period.
    """
    if away == 0.0:
        return 0.0
    distance = abs(away)
    forth = max(before if away > 0.0 else -before, 0.0)
    straight = distance / period_s
    if fresh and forth > 0.0 and distance <= max_speed * period_s * _NEARLY:
        most = min(straight, max_speed, forth + acceleration * period_s)
    else:
        # In steps of one period, what is left after this one is enough to brake in. With x the last
        # term, it is more / 2 * (sqrt(1 + x) - 1) in a form that holds for any effort.
        more = _SHARE * min(1.0, _LONG_S / period_s) * acceleration * period_s
        braking = 4.0 * straight / (sqrt(1.0 + 8.0 * straight / more) + 1.0)
        most = min(straight, max_speed, forth + more, braking)
    return copysign(most, away)


def feedforward_speed(speed: float, fed_before: float, expected: float, most_more: float) -> float:
    """Return the part of a set-point's speed that is fed forward to the drive.

    All of it where positions follow one another as a path, so that the joint does not lag, but no
    more than the periods before let expect: a path's first position may as well be a jump. In
    between, as much more in each period as the damper can answer with the joint's effort.

    None is towards a position that is not new or that takes more than a period: a command for a
    jump wants to come to rest at its end, for which the damper has to see the joint's speed.

    Args:
        speed: Of the set-point in this period.
        fed_before: What was fed forward in the period before.
        expected: What the periods before let expect of the speed.
        most_more: The change of speed that the damper alone answers with all the joint's effort.
    """
    before = fed_before if fed_before * speed > 0.0 else 0.0
    fed = speed
    if abs(speed) > abs(before):
        fed = before + min(max(speed - before, -most_more), most_more)
    return min(max(fed, min(expected, 0.0)), max(expected, 0.0))


def lag_distance(change: float, lag_s: float, acceleration: float) -> float:
    """Return the distance by which a joint lags behind its set-point after a change of speed.

    It does so as a first-order system, or, where that asks for more than all of its effort, at the
    acceleration of that until the rest of the change is within it.

    Args:
        change: Of the speed.
        lag_s: The time constant.
        acceleration: What all of the joint's effort can do.
    """
    within = min(abs(change), acceleration * lag_s)
    beyond = abs(change) - within
    lost = within * lag_s + beyond * (beyond + 2.0 * within) / (2.0 * acceleration)
    return copysign(lost, change)


def limited_lead(lead: float, pull: float, effort: float, stiffness: float) -> float:
    """Return how far a velocity command's set-point may lead its joint.

    No further than for the effort that the damper leaves it: what holds the joint back does not
    wind it up.

    Args:
        lead: What it is ahead by.
        pull: What the damper exerts.
        effort: The joint's own.
        stiffness: The spring's.
    """
    most = min(max(effort - pull, 0.0), effort) / stiffness
    least = -min(max(effort + pull, 0.0), effort) / stiffness
    return min(max(lead, least), most)


def speed_within_limits(speed: float, lower: float, upper: float, period_s: float) -> float:
    """Return a commanded speed, limited so that the joint stops at its position limits.

    Args:
        speed: The one that is wanted.
        lower: The lower limit, from where the joint would come to rest.
        upper: The upper limit, from there.
        period_s: The control period.
    """
    braking = max(period_s, _BRAKING_S)
    return min(max(speed, min(lower, 0.0) / braking), max(upper, 0.0) / braking)
