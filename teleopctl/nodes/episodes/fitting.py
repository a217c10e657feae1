"""Whether robot and cameras are there, and fit a data set, before an episode begins."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Any

from teleopctl.bag import CAMERA_PREFIX, STATE_FEATURE, EpisodeSettings
from teleopctl.errors import RefusedError, UnavailableError
from teleopctl.interfaces import get_message
from teleopctl.node import Node
from teleopctl.nodes.episodes.simulation import EpisodeSimulation
from teleopctl.pictures import (
    COMPRESSED,
    RAW,
    GreyScaling,
    PictureError,
    camera_name,
    camera_topics,
    image_of,
)

# Any, here and below: message classes are generated at run time from definitions.

# Longest wait for a first message of the robot, and of a camera, in seconds.
_FIRST_MESSAGE_S = 10.0
_JOINT_STATE = "sensor_msgs/msg/JointState"


class EpisodeFitting:
    """Comparison of the graph with the features of a data set, which is empty for a new one.

    Args:
        node: Node of the recorder.
        simulation: Reader of single messages.
        features: Features of the data set, by name.
        prefers_raw: Whether images are recorded uncompressed where there is a choice.
    """

    def __init__(
        self,
        node: Node,
        simulation: EpisodeSimulation,
        features: Mapping[str, Any],
        *,
        prefers_raw: bool,
    ) -> None:
        self._node, self._simulation = node, simulation
        self._features, self._prefers_raw = features, prefers_raw

    def is_published(self, settings: EpisodeSettings) -> bool:
        """Return whether the state and all named cameras have a publisher now."""
        topics = [settings.state, *(text.rpartition("=")[2] for text in settings.cameras)]
        return all(self._topic_of(topic) for topic in topics)

    def check_state(self, state: str) -> None:
        """Raise an error unless the robot's state is published, with the data set's joints.

        Args:
            state: Topic of the state, or a field of a topic.

        Raises:
            UnavailableError: Nothing publishes it.
            RefusedError: It lacks a joint.
        """
        self._node.context.wait_for_change(lambda: self._topic_of(state) != "", _FIRST_MESSAGE_S)
        topic = self._topic_of(state)
        if not topic:
            raise UnavailableError(
                f"Nothing publishes {state}, the state of the robot",
                hint="Start the robot, or name the topic: --state TOPIC (parameter 'state').",
            )
        feature = self._features.get(STATE_FEATURE, {})
        needed = [str(name).rpartition(".")[0] for name in feature.get("names") or ()]
        if not needed or topic != state or self._types()[topic] != [_JOINT_STATE]:
            return
        kind = get_message(_JOINT_STATE)
        message = self._simulation.next_message(kind, topic, _FIRST_MESSAGE_S)
        if message and (missing := [name for name in needed if name not in message.name]):
            raise RefusedError(
                f"The data set has the joint {missing[0]}, and {topic} has only "
                f"{', '.join(message.name)}: it is of another robot",
                hint="Record into another folder.",
            )

    def cameras(self, texts: tuple[str, ...]) -> dict[str, str]:
        """Return the topics of the images in the graph by the cameras' names.

        Waits for cameras of the data set, and for a first image of each: a simulated
        camera renders only while it has a subscriber, so its first image is late.

        Args:
            texts: Cameras that the user has named, ``TOPIC`` or ``NAME=TOPIC``; empty for all.

        Raises:
            UnavailableError: A camera that the user or the data set names publishes nothing.
            RefusedError: The data set has no such camera, or pictures of another size.
        """
        needed = self._needed()
        if not texts:
            self._node.context.wait_for_change(
                lambda: needed <= self._published().keys(), _FIRST_MESSAGE_S
            )
        named = [text.rpartition("=") for text in texts]
        chosen = {name or camera_name(topic): topic for name, _, topic in named}
        chosen = chosen or self._published()
        if missing := sorted(needed - chosen.keys()):
            raise UnavailableError(
                f"The data set has pictures of {', '.join(missing)}, and no such camera publishes",
                hint=f"Name its topic: --camera {missing[0]}=TOPIC (parameter 'cameras').",
            )
        found = {}
        for name, topic in chosen.items():
            if self._features and name not in needed:
                self._leave_out(name, topic, is_named=bool(texts))
                continue
            kind = COMPRESSED if topic.endswith("/compressed") else RAW
            image = self._simulation.next_message(get_message(kind), topic, _FIRST_MESSAGE_S)
            silence = f"No image has come on {topic} for {_FIRST_MESSAGE_S:g} s"
            if image is None and (texts or name in needed):
                raise UnavailableError(
                    silence, hint=f"Look at it: teleopctl topic hz {topic}; or record without it."
                )
            if image is None:
                self._node.get_logger().warning(f"{silence}: it is left out")
            else:
                self._check_size(name, image)
                found[name] = topic
        return found

    def _needed(self) -> set[str]:
        """Return the names of the data set's cameras."""
        return {
            key.removeprefix(CAMERA_PREFIX)
            for key in self._features
            if key.startswith(CAMERA_PREFIX)
        }

    def _leave_out(self, name: str, topic: str, *, is_named: bool) -> None:
        """Leave out a camera that the data set lacks.

        Raises:
            RefusedError: The user has named it.
        """
        has = ", ".join(sorted(self._needed())) or "none"
        text = f"The data set has no pictures of {name} (it has {has})"
        if is_named:
            raise RefusedError(text, hint="Record without it, or into another folder.")
        self._node.get_logger().warning(f"{text}: {topic} is left out")

    def _check_size(self, camera: str, image: Any) -> None:
        """Raise an error if an image has another size than a camera's pictures in the data set.

        Raises:
            RefusedError: It has another one.
        """
        shape = self._features.get(f"{CAMERA_PREFIX}{camera}", {}).get("shape")
        with contextlib.suppress(PictureError):
            width, height = image_of(image, GreyScaling()).size
            # A video's size is even.
            if shape and [height + height % 2, width + width % 2] != list(shape[:2]):
                raise RefusedError(
                    f"The data set has pictures of {shape[1]} x {shape[0]} from {camera}, and the "
                    f"camera has {width} x {height}",
                    hint="Set the camera's size, or record into another folder.",
                )

    def _types(self) -> dict[str, list[str]]:
        topics = self._node.get_topic_names_and_types()
        return {name: list(types) for name, types in topics if self._node.count_publishers(name)}

    def _topic_of(self, text: str) -> str:
        """Return the published topic of a text, a topic or a field; empty for none."""
        return next(
            (name for name in self._types() if text == name or text.startswith(f"{name}/")), ""
        )

    def _published(self) -> dict[str, str]:
        """Return the published image topics by the cameras' names, JPEG where there is a choice."""
        return camera_topics(self._types(), prefers_raw=self._prefers_raw)


def missing_topics(settings: EpisodeSettings, counts: Mapping[str, int]) -> str:
    """Return which of the chosen topics have no message; empty if all have."""
    wanted = [settings.state, *settings.action, *(c.rpartition("=")[2] for c in settings.cameras)]
    topics = [name for name in counts if counts[name]]
    missing = [
        text
        for text in wanted
        if not any(text == name or text.startswith(f"{name}/") for name in topics)
    ]
    return f"has no message of {', '.join(missing)}" if missing else ""
