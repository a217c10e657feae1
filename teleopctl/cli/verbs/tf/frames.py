"""The frames that somebody broadcasts, for whoever presses Tab."""

from __future__ import annotations

import threading

from teleopctl.base.typed import Any
from teleopctl.cli.command_node import command_node
from teleopctl.interfaces import get_message
from teleopctl.node import QoSProfile, qos_profile_latched
from teleopctl.tf import TF_STATIC_TOPIC, TF_TOPIC

# A person waits for this, in seconds; a robot sends its transforms at least this often.
_LONGEST_WAIT_S = 0.4


def heard_frames() -> set[str]:
    """Return the frames of the first received transforms.

    Raises:
        RouterNotRunning: No router answers.
    """
    message_class = get_message("tf2_msgs/msg/TFMessage")
    frames: set[str] = set()
    with command_node(session_mode="client") as node:
        heard = {
            topic: threading.Event()
            for topic in (TF_TOPIC, TF_STATIC_TOPIC)
            if node.count_publishers(topic) > 0
        }
        for topic, event in heard.items():

            def take(message: Any, event: threading.Event = event) -> None:
                for transform in message.transforms:
                    frames.update((transform.header.frame_id, transform.child_frame_id))
                event.set()

            latched = topic == TF_STATIC_TOPIC
            qos = qos_profile_latched if latched else QoSProfile(depth=10)
            node.create_subscription(message_class, topic, take, qos, immediate=True)
        for event in heard.values():
            event.wait(_LONGEST_WAIT_S)
        return set(frames)
