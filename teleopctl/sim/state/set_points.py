"""Speeds of drives' set-points from one control period to the next.

Each function is for one drive, in rad or m, and seconds. Plain numbers instead of arrays: for a
dozen drives they take a fifth of the time.
"""

from __future__ import annotations

from math import copysign, sqrt

# Fraction of the effort that a set-point's acceleration may take on the way to a fixed position:
# the rest is for weight, for loads from other joints, and for corrections of the spring. It is
# smaller in control periods longer than _LONG_S, since speeds change in steps between periods.
_SHARE, _LONG_S = 0.5, 0.05

# The shortest time in which a joint on a velocity command brakes before its limits, in seconds:
# two time constants of its drive.
_BRAKING_S = 0.01

# Greatest speed of positions that continue from a joint, as a factor of its speed: controllers may
# have to estimate it from measured positions.
_AT_MOST = 1.5

# Factor for rounding errors of a distance that is just within reach.
_NEARLY = 1.0 + 1e-6


def position_speed(
    away: float, before: float, fresh: bool, max_speed: float, acceleration: float, period_s: float
) -> float:
    """Return a drive's set-point speed for the next control period, towards a commanded position.

    The set-point moves straight to the next position of a path. From rest, and to a position that
    is not new or is further than one period, it accelerates and brakes with a fraction of the
    effort: the set-point comes to rest at the position, at whatever distance.

    Args:
        away: Distance to the position, with its sign.
        before: Speed in the previous period.
        fresh: Whether the position is new in this period.
        max_speed: Speed limit of the joint.
        acceleration: Acceleration at the full effort of the joint.
        period_s: Control period in seconds.
    """
    if away == 0.0:
        return 0.0
    distance = abs(away)
    forth = max(before if away > 0.0 else -before, 0.0)
    straight = distance / period_s
    if fresh and forth > 0.0 and distance <= max_speed * period_s * _NEARLY:
        most = min(straight, max_speed, forth + acceleration * period_s)
    else:
        # In steps of one period, the distance left after this one is enough to brake. With
        # x = 8 straight / more, the speed is more / 2 * (sqrt(1 + x) - 1), in a form that holds
        # for any effort.
        more = _SHARE * min(1.0, _LONG_S / period_s) * acceleration * period_s
        braking = 4.0 * straight / (sqrt(1.0 + 8.0 * straight / more) + 1.0)
        most = min(straight, max_speed, forth + more, braking)
    return copysign(most, away)


def goes_on_from_joint(
    joint_away: float,
    joint_speed: float,
    away: float,
    before: float,
    max_speed: float,
    period_s: float,
) -> bool:
    """Return whether a new position continues the joint's own motion, not that of its set-point.

    On the way to a distant position nothing is fed forward, and the set-point is ahead of the joint
    by the lag of the drive and by its acceleration. Positions that then continue from the joint, at
    about its speed, as those of a stop do, would stop the set-point until the joint has caught up
    with it.

    Args:
        joint_away: Distance from the joint to the position, with its sign.
        joint_speed: Speed of the joint.
        away: Distance from the set-point to the position.
        before: Speed of the set-point in the previous period.
        max_speed: Speed limit of the joint.
        period_s: Control period in seconds.
    """
    farthest = min(_AT_MOST * abs(joint_speed), max_speed) * period_s * _NEARLY
    # A trajectory's positions are ahead of the set-point.
    is_behind = away * joint_speed <= 0.0
    if not is_behind or joint_away * joint_speed <= 0.0 or abs(joint_away) > farthest:
        return False
    return abs(joint_away / period_s - joint_speed) < abs(away / period_s - before)


def feedforward_speed(speed: float, fed_before: float, expected: float, most_more: float) -> float:
    """Return the part of a set-point's speed that is fed forward, so that the joint does not lag.

    Along a path of positions the whole speed is fed forward, so that the joint does not lag, but
    no more than expected from the previous periods: a path's first position may as well be a jump.
    In between, the part grows in each period by what the damper can answer with the joint's effort.

    Callers feed nothing forward to a position that is not new or is further than one period: at
    the end of a jump the joint is to rest, for which the damper must act on the joint's own speed.

    Args:
        speed: Speed of the set-point in this period.
        fed_before: Speed that was fed forward in the previous period.
        expected: Speed expected from the previous periods.
        most_more: Change of speed that the damper alone answers with the joint's full effort.
    """
    before = fed_before if fed_before * speed > 0.0 else 0.0
    fed = speed
    if abs(speed) > abs(before):
        fed = before + min(max(speed - before, -most_more), most_more)
    return min(max(fed, min(expected, 0.0)), max(expected, 0.0))


def lag_distance(change: float, lag_s: float, acceleration: float) -> float:
    """Return the distance by which a joint lags behind its set-point after a change of speed.

    The joint lags as a first-order system. Where this needs more than its full effort, it
    accelerates at full effort until the rest of the change needs no more.

    Args:
        change: Change of the speed.
        lag_s: Time constant of the first-order system, in seconds.
        acceleration: Acceleration at the full effort of the joint.
    """
    within = min(abs(change), acceleration * lag_s)
    beyond = abs(change) - within
    lost = within * lag_s + beyond * (beyond + 2.0 * within) / (2.0 * acceleration)
    return copysign(lost, change)


def limited_lead(lead: float, pull: float, effort: float, stiffness: float) -> float:
    """Return a set-point's lead over its joint, limited to the effort that the damper leaves.

    The spring gets at most the effort that the damper leaves: a joint that is held back does not
    wind up.

    Args:
        lead: Distance by which the set-point is ahead.
        pull: Effort of the damper.
        effort: Effort limit of the joint.
        stiffness: Stiffness of the spring.
    """
    most = min(max(effort - pull, 0.0), effort) / stiffness
    least = -min(max(effort + pull, 0.0), effort) / stiffness
    return min(max(lead, least), most)


def speed_within_limits(speed: float, lower: float, upper: float, period_s: float) -> float:
    """Return a commanded speed, limited so that the joint stops at its position limits.

    Args:
        speed: Commanded speed.
        lower: Lower limit, relative to the position where the joint would come to rest.
        upper: Upper limit, relative to that position.
        period_s: Control period in seconds.
    """
    braking = max(period_s, _BRAKING_S)
    return min(max(speed, min(lower, 0.0) / braking), max(upper, 0.0) / braking)
