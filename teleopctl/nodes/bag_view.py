"""Viewer of a bag on a web page: a player and a viewer in a domain of their own."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable
from pathlib import Path

from teleopctl.bag import Player, PlayOptions, open_bag
from teleopctl.base.token_file import Address
from teleopctl.node import (
    ExternalShutdownException,
    Node,
    SingleThreadedExecutor,
    init,
    qos_profile_latched,
)
from teleopctl.wire import ensure_router

_PLAYER = "rosbag2_player"
_CLOCK_HZ = 40.0
_DESCRIPTION = "/robot_description"
# Above the 233 domain IDs that users can choose.
_FIRST_DOMAIN = 1000


def view_bag(
    path: Path,
    *,
    host: str,
    port: int | None,
    token_file: Path | None,
    view: Path | None,
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
        rate: Playback rate: seconds of the bag per second.
        is_paused: Whether playback starts paused.
        on_ready: Called with the page's address and the domain ID, when the page is ready.

    Raises:
        TeleopctlError: The bag or the view cannot be read, or the page cannot be opened.
    """
    # Read first, so that an unreadable bag opens no page.
    with open_bag(path) as bag:
        has_description = any(t.name == _DESCRIPTION and n for t, n in bag.metadata.topics)
        attached = [] if has_description else [*bag.attachments()]
    description = next((a.data for a in attached if a.name == "robot_description.urdf"), None)
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
        node = stack.enter_context(Node(_PLAYER))
        if description is not None:
            _publish_description(node, description)
        player = stack.enter_context(Player(node, path, options))
        executor = SingleThreadedExecutor()
        for each in (viewer, node):
            executor.add_node(each)
        player.play()
        on_ready(address, domain)
        executor.spin()


def _publish_description(node: Node, urdf: bytes) -> None:
    """Publish the robot description that the bag holds as an attachment."""
    from teleopctl.interfaces import get_message

    string = get_message("std_msgs/msg/String")
    publisher = node.create_publisher(string, _DESCRIPTION, qos_profile_latched)
    publisher.publish(string(data=urdf.decode(errors="replace")))
