"""Newest values of a running robot: its joints, the references of controllers, and its cameras."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from teleopctl.errors import NotFoundError, UnavailableError, did_you_mean
from teleopctl.interfaces import get_message
from teleopctl.node import Node
from teleopctl.pictures import (
    COMPRESSED,
    DEPTH_ENCODINGS,
    RAW,
    GreyScaling,
    PictureError,
    camera_topics,
    image_of,
)

Pixels = npt.NDArray[np.uint8]
"""RGB image, shape (height, width, 3)."""

FIRST_S = 10.0
"""Longest wait for the first message of a topic, in seconds."""

_JOINT_STATE = "sensor_msgs/msg/JointState"
_REFERENCE = "control_msgs/msg/JointTrajectoryControllerState"
# Age at which values are no longer those of a robot that runs, in seconds.
_SILENT_S = 1.0

# Any, here and below: message classes are generated at run time from definitions.


class NewestPositions:
    """Newest positions of joints on a topic: joint states, or the reference of a controller.

    Args:
        node: Node of the subscription.
        topic: Topic of type JointState or JointTrajectoryControllerState.

    Raises:
        NotFoundError: The topic has another type.
        UnavailableError: No message comes.
    """

    def __init__(self, node: Node, topic: str) -> None:
        self._topic = node.resolve_topic_name(topic)
        self._positions: dict[str, float] = {}
        self._at_s = 0.0
        self._came = threading.Event()
        kinds = _kinds(node, self._topic, FIRST_S)
        known = {_JOINT_STATE: self._take_state, _REFERENCE: self._take_reference}
        kind = next((each for each in kinds if each in known), None)
        if kind is None:
            raise NotFoundError(f"{self._topic} has {', '.join(kinds)}, not {' or '.join(known)}")
        node.create_subscription(get_message(kind), self._topic, known[kind], 1)
        if not self._came.wait(FIRST_S):
            raise UnavailableError(f"No message has come on {self._topic} for {FIRST_S:g} s")

    def read(self) -> dict[str, float]:
        """Return the positions by joint, rad or m.

        Raises:
            UnavailableError: The topic is silent.
        """
        if time.monotonic() - self._at_s > _SILENT_S:
            raise UnavailableError(f"{self._topic} is silent: does the robot still run?")
        return self._positions

    def _take_state(self, message: Any) -> None:
        self._take(message.name, message.position)

    def _take_reference(self, message: Any) -> None:
        self._take(message.joint_names, message.reference.positions)

    def _take(self, names: Any, positions: Any) -> None:
        if not len(positions):
            return
        values = zip(names, map(float, positions), strict=False)
        self._positions = {**self._positions, **dict(values)}
        self._at_s = time.monotonic()
        self._came.set()


class NewestImages:
    """Newest images of cameras.

    Args:
        node: Node of the subscriptions.
        topics: Image topics by the cameras' names; empty for all colour cameras that publish.

    Attributes:
        sizes: Height and width of the images of each camera, in pixels.

    Raises:
        UnavailableError: A camera that is named publishes nothing.
    """

    def __init__(self, node: Node, topics: Mapping[str, str]) -> None:
        self.sizes: dict[str, tuple[int, int]] = {}
        self._newest: dict[str, Pixels] = {}
        self._at_s: dict[str, float] = {}
        self._changed = threading.Condition()
        found = dict(topics) or _cameras(node)
        for name, topic in found.items():
            self._subscribe(node, name, topic)
        with self._changed:
            self._changed.wait_for(lambda: found.keys() <= self._newest.keys(), FIRST_S)
        for name, topic in found.items():
            if name in self._newest:
                height, width = self._newest[name].shape[:2]
                self.sizes[name] = height, width
            elif topics:
                raise UnavailableError(f"No image has come on {topic} for {FIRST_S:g} s")

    def read(self) -> dict[str, Pixels]:
        """Return the newest image of each camera.

        Raises:
            UnavailableError: A camera is silent, or its images have another size.
        """
        now_s = time.monotonic()
        for name, (height, width) in self.sizes.items():
            if now_s - self._at_s[name] > _SILENT_S:
                raise UnavailableError(f"The camera '{name}' is silent")
            if self._newest[name].shape[:2] != (height, width):
                raise UnavailableError(f"The images of '{name}' have changed their size")
        return {name: self._newest[name] for name in self.sizes}

    def _subscribe(self, node: Node, name: str, topic: str) -> None:
        scaling = GreyScaling()

        def take(message: Any) -> None:
            if getattr(message, "encoding", "") in DEPTH_ENCODINGS:
                return
            try:
                pixels = np.asarray(image_of(message, scaling).convert("RGB"))
            except PictureError:
                return
            with self._changed:
                self._newest[name], self._at_s[name] = pixels, time.monotonic()
                self._changed.notify_all()

        kind = COMPRESSED if topic.endswith("/compressed") else RAW
        node.create_subscription(get_message(kind), topic, take, 1)


def _kinds(node: Node, topic: str, longest_s: float) -> list[str]:
    """Return the types of a topic, after waiting for a publisher."""
    known: dict[str, list[str]] = {}

    def is_there() -> bool:
        known.update(node.get_topic_names_and_types())
        return topic in known

    node.context.wait_for_change(is_there, longest_s)
    if topic not in known:
        raise UnavailableError(
            f"No node publishes {topic}", hint=did_you_mean(topic, known) or "Does the robot run?"
        )
    return known[topic]


def _cameras(node: Node) -> dict[str, str]:
    """Return the image topics that are published by the cameras' names, JPEG where there is one."""
    topics = node.get_topic_names_and_types()
    return camera_topics({name: types for name, types in topics if node.count_publishers(name)})
