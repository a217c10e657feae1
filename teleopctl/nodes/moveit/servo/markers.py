"""Publishers of servo's status, and of markers where a singularity, limit or collision slows it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from teleopctl.interfaces import from_seconds, get_message, set_stamp
from teleopctl.kinematics import GroupKinematics, Reason, StatusCode
from teleopctl.node import Node

TOPIC = "~/status_markers"
_NAMESPACE = "servo"
# Sizes as parts of the arm's reach: height of the text and its distance above the arm, diameter of
# the ball around a place between two bodies, and of that around a joint, which is inside of links.
_TEXT, _ABOVE, _BALL, _JOINT_BALL = 0.06, 0.18, 0.12, 0.25
# Colours, red to alpha: of what halts the arm, and of what slows it down.
_HALTED, _SLOWED = (0.95, 0.15, 0.1, 0.5), (1.0, 0.6, 0.0, 0.5)
_SLOWING = frozenset(
    {
        StatusCode.NO_WARNING,
        StatusCode.DECELERATE_FOR_APPROACHING_SINGULARITY,
        StatusCode.DECELERATE_FOR_LEAVING_SINGULARITY,
        StatusCode.DECELERATE_FOR_COLLISION,
    }
)
# Markers are published this often, s, while they hold, and disappear by themselves after this time.
_PERIOD_S, _LIFETIME_S = 0.1, 1.0

# Any, here and below: message classes are generated at run time from definitions.


class StatusPublisher:
    """Publisher of servo's status: at each change, and ten times a second of a motion.

    MoveIt publishes it with each step; but each message wakes all of its receivers.

    Args:
        node: Node of the publisher.
        topic: Name of the topic.
    """

    def __init__(self, node: Node, topic: str) -> None:
        self._status: Any = get_message("moveit_msgs/msg/ServoStatus")()
        self._publisher = node.create_publisher(type(self._status), topic, 10)
        self._due_s = 0.0

    def publish(self, code: StatusCode, message: str, *, is_stepping: bool) -> None:
        """Publish a status, if it is a new one or due.

        Args:
            code: Its code.
            message: Its text.
            is_stepping: Whether it is that of one of many steps.
        """
        status, now_s = self._status, time.monotonic()
        is_same = (status.code, status.message) == (int(code), message)
        if is_same and is_stepping and now_s < self._due_s:
            return
        status.code, status.message = int(code), message
        self._due_s = now_s + _PERIOD_S
        self._publisher.publish(status)


class StatusMarkers:
    """Publisher of markers at what slows servo down, while there are subscribers.

    Args:
        node: Node of the publisher.
    """

    def __init__(self, node: Node) -> None:
        self._array: Any = get_message("visualization_msgs/msg/MarkerArray")
        self._marker: Any = get_message("visualization_msgs/msg/Marker")
        self._publisher = node.create_publisher(self._array, TOPIC, 10)
        self._shown = 0
        self._words = ""
        self._due_s = 0.0

    def show(self, frame: str, kinematics: GroupKinematics, reasons: Sequence[Reason]) -> None:
        """Show the reasons of a step; none removes the markers.

        Args:
            frame: Root link.
            kinematics: Kinematics of the group, at the present state.
            reasons: What made the step slower than its command.
        """
        if not reasons:
            if self._shown:
                self._publish([self._deleted(number) for number in range(self._shown)])
                self._shown, self._words = 0, ""
            return
        words = "; ".join(dict.fromkeys(reason.text for reason in reasons))
        now_s = time.monotonic()
        if not self._publisher.get_subscription_count() or (
            words == self._words and now_s < self._due_s
        ):
            return
        self._words, self._due_s = words, now_s + _PERIOD_S
        reach_m = kinematics.reach_m
        x, y, z = kinematics.pose()[:3, 3].tolist()
        # Links would hide it elsewhere.
        top = max(z, *(kinematics.model.joint_origin(name)[2] for name in kinematics.names))
        color = _SLOWED if all(reason.code in _SLOWING for reason in reasons) else _HALTED
        text = self._new(frame, 0, (x, y, float(top) + _ABOVE * reach_m), (*color[:3], 1.0))
        text.type, text.text, text.scale.z = self._marker.TEXT_VIEW_FACING, words, _TEXT * reach_m
        markers = [text]
        places = {reason.place: reason.code for reason in reasons if reason.place is not None}
        for number, (place, code) in enumerate(places.items(), start=1):
            ball = self._new(frame, number, place, color)
            ball.type = self._marker.SPHERE
            size_m = reach_m * (_JOINT_BALL if code is StatusCode.JOINT_BOUND else _BALL)
            ball.scale.x = ball.scale.y = ball.scale.z = size_m
            markers.append(ball)
        count = len(markers)
        markers += [self._deleted(number) for number in range(count, self._shown)]
        self._shown = count
        self._publish(markers)

    def _new(self, frame: str, number: int, place: Sequence[float], color: Sequence[float]) -> Any:
        marker = self._marker(ns=_NAMESPACE, id=number, action=self._marker.ADD)
        marker.header.frame_id = frame
        at, turn = marker.pose.position, marker.pose.orientation
        at.x, at.y, at.z = place
        turn.w = 1.0
        marker.color.r, marker.color.g, marker.color.b, marker.color.a = color
        set_stamp(marker.lifetime, from_seconds(_LIFETIME_S))
        return marker

    def _deleted(self, number: int) -> Any:
        return self._marker(ns=_NAMESPACE, id=number, action=self._marker.DELETE)

    def _publish(self, markers: list[Any]) -> None:
        self._publisher.publish(self._array(markers=markers))
