"""Peer processes of the page benchmarks.

``python -m tests.benchmarks.page_peers minimal URDF`` is a minimal script of viser with yourdfpy;
``… moving URDF`` also moves the joints at 50 Hz and shows an image at 30 Hz. ``… feed JOINT…`` is a
node that publishes the same joint positions and images.
"""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

JOINTS_HZ, PICTURES_HZ = 50, 30
PICTURE_WIDTH, PICTURE_HEIGHT = 640, 480


def positions(count: int) -> list[float]:
    return [0.3 * math.sin(time.monotonic() + number) for number in range(count)]


def picture() -> Any:
    """Return an image of moving bars, which differs at each call."""
    import numpy as np

    bars = np.arange(PICTURE_WIDTH) + int(100 * time.monotonic())
    row = np.stack([bars, bars // 2, bars // 4], axis=1).astype(np.uint8)
    return np.broadcast_to(row, (PICTURE_HEIGHT, PICTURE_WIDTH, 3))


def at(rate: int, do: Callable[[], object]) -> None:
    """Call a function at a rate in Hz, without end."""
    due = time.monotonic()
    while True:
        do()
        due = max(due + 1 / rate, time.monotonic() - 1.0)
        time.sleep(max(0.0, due - time.monotonic()))


def minimal(urdf: str, *, moves: bool) -> None:
    import numpy as np
    import viser
    import yourdfpy
    from viser.extras import ViserUrdf

    from teleopctl.packages import package_share

    def file_of(fname: str) -> str:
        package, _, rest = fname.removeprefix("package://").partition("/")
        return str(package_share(package) / rest)

    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    robot = ViserUrdf(server, yourdfpy.URDF.load(urdf, filename_handler=file_of))
    joints = len(robot.get_actuated_joint_names())
    robot.update_cfg(np.zeros(joints))
    server.initial_camera.position, server.initial_camera.look_at = (2, -2, 1.5), (0, 0, 0.7)
    print(f"http://localhost:{server.get_port()}/", flush=True)
    if moves:
        image = server.gui.add_image(picture())

        def show() -> None:
            image.image = picture()

        threading.Thread(target=at, args=(PICTURES_HZ, show), daemon=True).start()
        at(JOINTS_HZ, lambda: robot.update_cfg(np.array(positions(joints))))
    threading.Event().wait()


def feed(names: list[str]) -> None:
    from teleopctl.interfaces import get_message
    from teleopctl.node import Node, init, spin

    with init(args=[]), Node("feed") as node:
        state = get_message("sensor_msgs/msg/JointState")(name=names)
        image = get_message("sensor_msgs/msg/Image")(
            width=PICTURE_WIDTH, height=PICTURE_HEIGHT, step=3 * PICTURE_WIDTH, encoding="rgb8"
        )
        states = node.create_publisher(type(state), "joint_states", 10)
        images = node.create_publisher(type(image), "image_raw", 1)

        def move() -> None:
            state.header.stamp = node.get_clock().now().to_msg()
            state.position = state.velocity = positions(len(names))
            states.publish(state)

        def show() -> None:
            image.header.stamp = node.get_clock().now().to_msg()
            image.data = picture().tobytes()
            images.publish(image)

        node.create_timer(1 / JOINTS_HZ, move)
        node.create_timer(1 / PICTURES_HZ, show)
        spin(node)


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["feed", *names]:
            feed(names)
        case [kind, urdf]:
            minimal(urdf, moves=kind == "moving")
