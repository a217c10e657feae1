"""Simulator of a robot whose episodes are recorded: reset, random object poses, state."""

from __future__ import annotations

import math
import tempfile
import threading
from pathlib import Path
from typing import Any

from teleopctl.errors import RefusedError, UnavailableError
from teleopctl.interfaces import get_message, get_service
from teleopctl.node import MutuallyExclusiveCallbackGroup, Node, qos_profile_latched
from teleopctl.robot import COMMANDS_TOPIC

# Any, here and below: message classes are generated at run time from definitions.

_SIMULATOR = "/mujoco_sim"
_MUJOCO = "mujoco_ros2_control_msgs"
_BODIES_TOPIC = f"{_SIMULATOR}/free_joint_states"
# Longest wait for an answer of the simulator, in seconds.
_LONGEST_S = 10.0
# Longest wait for the first command of the controllers to the simulator, in seconds.
_FIRST_COMMAND_S = 0.5


class EpisodeSimulation:
    """Simulator of the robot, if there is one: reset with objects at random poses, and state."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._group = MutuallyExclusiveCallbackGroup()
        reset = get_service(f"{_MUJOCO}/srv/ResetWorld")
        self._reset, self._save = (
            node.create_client(reset, f"{_SIMULATOR}/{name}", callback_group=self._group)
            for name in ("reset_world", "save_world")
        )
        # Poses of the free objects at the start, by name.
        self._homes: dict[str, Any] = {}

    def reset(self, seed: int, number: int) -> None:
        """Reset the world, and place its free objects at random.

        Raises:
            UnavailableError: There is no simulator, or it does not answer.
            RefusedError: It refuses the request.
        """
        import numpy as np

        if not self._reset.service_is_ready():
            raise UnavailableError(
                "There is no simulation to reset", hint="Record with reset:=false."
            )
        request: Any = get_service(f"{_MUJOCO}/srv/ResetWorld").Request()
        if not self._homes:
            self._call(self._reset, request)
            self._homes = self._bodies()
        random = np.random.default_rng([seed, number])
        reach_m, turn = (
            float(self._node.get_parameter(f"reset.{name}").value) for name in ("position", "yaw")
        )
        state: Any = get_message(f"{_MUJOCO}/msg/FreeJointState")
        for name, home in sorted(self._homes.items()):
            x, y, yaw = random.uniform(-1.0, 1.0, 3) * (reach_m, reach_m, turn)
            body = state(name=name)
            body.pose.header.frame_id = home.header.frame_id
            at, was = body.pose.pose.position, home.pose.position
            at.x, at.y, at.z = was.x + x, was.y + y, was.z
            q, half = home.pose.orientation, 0.5 * yaw
            c, s = math.cos(half), math.sin(half)
            rotation = body.pose.pose.orientation
            rotation.w, rotation.x = c * q.w - s * q.z, c * q.x - s * q.y
            rotation.y, rotation.z = c * q.y + s * q.x, c * q.z + s * q.w
            request.state_overrides.free_joints.append(body)
        self._call(self._reset, request)

    def state(self) -> bytes:
        """Return the state of the simulation, with all commands after it recorded; b"" without one.

        Raises:
            RefusedError: The simulator refuses the request.
        """
        if not self._save.service_is_ready():
            return b""
        # The recorder's subscription to the commands is older than this one.
        self.next_message(
            get_message("sensor_msgs/msg/JointState"), COMMANDS_TOPIC, _FIRST_COMMAND_S
        )
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "state.json"
            request: Any = get_service(f"{_MUJOCO}/srv/ResetWorld").Request(keyframe=str(file))
            self._call(self._save, request)
            # A simulator on another machine has written its file there.
            return file.read_bytes() if file.exists() else b""

    def _bodies(self) -> dict[str, Any]:
        """Return the stamped poses of the free objects by name, without the robot's own links."""
        message = self.next_message(
            get_message(f"{_MUJOCO}/msg/FreeJointStateArray"), _BODIES_TOPIC, _LONGEST_S
        )
        described = self.next_message(
            get_message("std_msgs/msg/String"),
            "/robot_description",
            _LONGEST_S,
            is_latched=True,
        )
        text = "" if described is None else described.data
        bodies = () if message is None else message.free_joints
        return {body.name: body.pose for body in bodies if f'"{body.name}"' not in text}

    def next_message(
        self, kind: Any, topic: str, longest_s: float, *, is_latched: bool = False
    ) -> Any:
        """Return the next message of a topic, or None if none comes within a time in seconds."""
        received: list[Any] = []
        came = threading.Event()

        def take(message: Any) -> None:
            received.append(message)
            came.set()

        subscription = self._node.create_subscription(
            kind, topic, take, qos_profile_latched if is_latched else 1, callback_group=self._group
        )
        came.wait(longest_s)
        self._node.destroy_subscription(subscription)
        return received[0] if received else None

    def _call(self, client: Any, request: Any) -> None:
        response = client.call(request, _LONGEST_S)
        if response is None:
            raise UnavailableError(f"The simulator has not answered for {_LONGEST_S:g} s")
        if not response.success:
            raise RefusedError(f"The simulator has refused: {response.message}")
