"""Viewer of a bag on a web page: a player and a viewer in a domain of their own."""

from __future__ import annotations

import contextlib
import math
import os
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.bag import MARKS_PARAMETER, Decoder, OverlaidBag, Player, PlayOptions, open_bag
from teleopctl.base.token_file import Address
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import NANOSECONDS_PER_SECOND
from teleopctl.node import (
    ExternalShutdownException,
    Node,
    Parameter,
    SingleThreadedExecutor,
    init,
    qos_profile_latched,
)
from teleopctl.wire import ensure_router

if TYPE_CHECKING:
    from teleopctl.bag import Bag

_PLAYER = "rosbag2_player"
_CLOCK_HZ = 40.0
_DESCRIPTION = "/robot_description"
# Above the 233 domain IDs that users can choose.
_FIRST_DOMAIN = 1000
OVER = "over"
"""Prefix of the topics and frames of a bag that is shown over another one."""

_OVER_ALPHA = 0.4


def view_bag(
    path: Path,
    *,
    host: str,
    port: int | None,
    token_file: Path | None,
    view: Path | None,
    over: Path | None = None,
    rate: float,
    is_paused: bool,
    on_ready: Callable[[Address, int], object],
) -> None:
    """Play a bag in a ROS domain of its own, and serve a web page that shows it, until Ctrl-C.

    The player and the viewer share a domain without other nodes: other nodes do not receive the
    played messages, and the page does not show other nodes.

    Args:
        path: Path of the bag.
        host: Address to listen on; see `open_server`.
        port: Port to listen on; see `open_server`.
        token_file: File of the page's token; see `open_viewer`.
        view: ``.rviz`` file that the page shows first.
        over: Path of a second bag to show over the first one, from the same time on; its topics and
            frames get the prefix ``over``.
        rate: Playback rate: seconds of the bag per second.
        is_paused: Whether playback starts paused.
        on_ready: Called with the page's address and the domain ID, when the page is ready.

    Raises:
        TeleopctlError: The bag or the view cannot be read, or the page cannot be opened.
    """
    # Read first, so that an unreadable bag opens no page.
    with open_bag(path) as bag:
        descriptions = {_DESCRIPTION: _attached_description(bag)}
    if over is not None:
        with open_bag(over) as bag:
            descriptions[f"/{OVER}{_DESCRIPTION}"] = _attached_description(bag)
    ensure_router()
    domain = _FIRST_DOMAIN + os.getpid()
    arguments = ["--ros-args", "-p", "use_sim_time:=true"]
    options = PlayOptions(rate=rate, loop=True, is_paused=is_paused, clock_hz=_CLOCK_HZ)
    from teleopctl.viewer import load_layout, open_viewer

    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=arguments, domain_id=domain),
        contextlib.ExitStack() as stack,
    ):
        viewer, address = open_viewer(host, port, token_file, view=view, layout=load_layout("bag"))
        stack.enter_context(viewer)
        viewer.plot_recording(BagRecording(path, over))
        node = stack.enter_context(Node(_PLAYER))
        for topic, description in descriptions.items():
            if description is not None:
                _publish_description(node, topic, description)
        bags = [stack.enter_context(open_bag(path))]
        if over is not None:
            bags.append(stack.enter_context(OverlaidBag(open_bag(over), bags[0], OVER)))
            viewer.scene_view.add(
                "RobotModel",
                f"Robot of {over.name}",
                {
                    "Description Topic": {"Value": f"/{OVER}{_DESCRIPTION}"},
                    "TF Prefix": OVER,
                    "Alpha": _OVER_ALPHA,
                },
            )
        player = stack.enter_context(Player(node, bags, options))
        executor = SingleThreadedExecutor()
        for each in (viewer, node):
            executor.add_node(each)
        player.play()
        on_ready(address, domain)
        threading.Thread(
            target=_offer_marks, args=(node, path), name="bag-marks", daemon=True
        ).start()
        executor.spin()


class BagRecording:
    """Bag, or two bags over each other, from whose files the page's plots are read.

    Args:
        path: Path of the bag.
        over: Path of the bag over it; None for none.
    """

    def __init__(self, path: Path, over: Path | None = None) -> None:
        self._path, self._over = path, over
        self.start_s = math.inf
        self.end_s = -math.inf
        names: list[str] = []
        for is_over in (False, *([True] if over else [])):
            with self._open(is_over=is_over) as bag:
                names += [topic.name for topic, _ in bag.metadata.topics]
                for file in bag.metadata.files:
                    if file.message_count:
                        self.start_s = min(self.start_s, file.start_ns / NANOSECONDS_PER_SECOND)
                        self.end_s = max(self.end_s, file.end_ns / NANOSECONDS_PER_SECOND)
        # Transforms of both bags are one topic, which is played only.
        self.topics = frozenset(name for name in names if names.count(name) == 1)

    @contextlib.contextmanager
    def _open(self, *, is_over: bool) -> Iterator[Bag]:
        with contextlib.ExitStack() as stack:
            bag = stack.enter_context(open_bag(self._path))
            if is_over and self._over is not None:
                bag = stack.enter_context(OverlaidBag(open_bag(self._over), bag, OVER))
            yield bag

    # Any: a message, whose class is made from its definition in the bag.
    def messages(self, topic: str) -> Iterator[tuple[float, Any]]:
        """Yield time of receipt (s since the epoch) and content of each message of a topic.

        Args:
            topic: Name of the topic; that of the bag over the first one begins with ``/over/``.

        Raises:
            TeleopctlError: The topic cannot be read.
        """
        is_over = self._over is not None and topic.startswith(f"/{OVER}/")
        with self._open(is_over=is_over) as bag:
            for decoded in Decoder(bag, [topic]).messages():
                yield decoded.log_time_ns / NANOSECONDS_PER_SECOND, decoded.message


def _attached_description(bag: Bag) -> bytes | None:
    """Return the robot description that the bag holds as an attachment, if none is recorded."""
    if any(topic.name == _DESCRIPTION and count for topic, count in bag.metadata.topics):
        return None
    attached = (one.data for one in bag.attachments() if one.name == "robot_description.urdf")
    return next(attached, None)


def _offer_marks(node: Node, path: Path) -> None:
    """Read the bag's marks, and offer them to the time line as a parameter of the player."""
    from teleopctl.nodes.bag_marks import bag_marks

    try:
        marks = [f"{mark.time_ns} {mark.kind} {mark.text}" for mark in bag_marks(path)]
        if marks and node.context.ok():
            node.set_parameters([Parameter(MARKS_PARAMETER, value=marks)])
    except TeleopctlError as error:
        node.get_logger().warning(f"No marks on the time line: {error}")


def _publish_description(node: Node, topic: str, urdf: bytes) -> None:
    """Publish a robot description."""
    from teleopctl.interfaces import get_message

    string = get_message("std_msgs/msg/String")
    publisher = node.create_publisher(string, topic, qos_profile_latched)
    publisher.publish(string(data=urdf.decode(errors="replace")))
