"""A robot of the ROS 2 graph as a robot of lerobot's programs: ``--robot.type=teleopctl``."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from lerobot.robots import Robot, RobotConfig

from teleopctl.commander import CommandPublisher, Controllers, StreamKind, choose_streams
from teleopctl.errors import InvalidParameterError, NotFoundError
from teleopctl.lerobot.newest import FIRST_S, NewestImages, NewestPositions
from teleopctl.node import Node, open_node

_SUFFIX = ".pos"


@RobotConfig.register_subclass("teleopctl")
@dataclass(kw_only=True)
class TeleopctlRobotConfig(RobotConfig):
    """Configuration of a robot of the graph; the domain is that of ``ROS_DOMAIN_ID``.

    Attributes:
        namespace: Namespace of the robot.
        joint_states: Topic of the robot's joint states.
        images: Image topics by the cameras' names; empty for all colour cameras that publish.
        joints: Joints that are commanded; empty for all that active controllers move.
        ahead_s: Time within which a trajectory controller reaches a position, in seconds.
        max_step: Largest distance of a commanded position from the measured one, rad or m; 0 for
            any: the controllers' limits hold in any case.
        sends_actions: Whether actions are sent to the controllers; false while a device drives the
            robot through servo, and lerobot only records.
    """

    namespace: str = ""
    joint_states: str = "joint_states"
    images: dict[str, str] = field(default_factory=dict)
    joints: list[str] = field(default_factory=list)
    ahead_s: float = 0.05
    max_step: float = 0.0
    sends_actions: bool = True


class TeleopctlRobot(Robot):
    """Robot of the graph, in simulation or not, by its joint states, cameras and controllers.

    Positions are in rad or m, as on the topics.

    Args:
        config: Configuration of the robot.
    """

    config_class = TeleopctlRobotConfig
    name = "teleopctl"

    def __init__(self, config: TeleopctlRobotConfig) -> None:
        super().__init__(config)
        self.config = config
        self._exit = ExitStack()
        self._is_connected = False

    # --- the graph, which is looked at when it is first needed ----------------------------

    @cached_property
    def _node(self) -> Node:
        return self._exit.enter_context(open_node("lerobot_robot", namespace=self.config.namespace))

    @cached_property
    def _positions(self) -> NewestPositions:
        return NewestPositions(self._node, self.config.joint_states)

    @cached_property
    def _images(self) -> NewestImages:
        return NewestImages(self._node, self.config.images)

    @cached_property
    def _publishers(self) -> list[CommandPublisher]:
        controllers = Controllers(self._node).available()
        joints = self.config.joints or [
            joint for one in controllers if one.stream is not None for joint in one.joints
        ]
        joints = list(dict.fromkeys(joints))
        streams = choose_streams(controllers, joints)
        if not streams:
            named = ", ".join(joints) or "any joint"
            raise NotFoundError(
                f"No active controller takes a stream of positions for {named}",
                hint="See `teleopctl control list_controllers`.",
            )
        for stream in streams:
            if stream.kind is StreamKind.ARRAY and stream.quantity != "position":
                raise NotFoundError(f"{stream.topic} takes {stream.quantity}, not positions")
        return [CommandPublisher(self._node, one, self.config.ahead_s) for one in streams]

    # --- lerobot's interface --------------------------------------------------------------

    # Any: as lerobot's.
    @property
    def cameras(self) -> dict[str, Any]:
        """Cameras by name, with height and width; lerobot counts them."""
        return dict(self._images.sizes)

    # Any: as lerobot's.
    @cached_property
    def observation_features(self) -> dict[str, Any]:
        """Type of each joint's position, and shape of each camera's images."""
        joints = {f"{name}{_SUFFIX}": float for name in self._positions.read()}
        return {**joints, **{name: (*size, 3) for name, size in self._images.sizes.items()}}

    # Any: as lerobot's.
    @cached_property
    def action_features(self) -> dict[str, Any]:
        """Type of each commanded position."""
        joints = [joint for one in self._publishers for joint in one.target.joints]
        return {f"{joint}{_SUFFIX}": float for joint in joints}

    @property
    def is_connected(self) -> bool:
        """Whether `connect` was called."""
        return self._is_connected

    def connect(self, calibrate: bool = True) -> None:
        """Wait until the robot's joints and cameras are received, and its controllers found.

        Raises:
            UnavailableError: A topic is silent.
            NotFoundError: No controller takes positions.
        """
        del calibrate
        _ = self.observation_features
        if self.config.sends_actions:
            for publisher in self._publishers:
                publisher.wait_for_subscriber(FIRST_S)
        self._is_connected = True

    @property
    def is_calibrated(self) -> bool:
        """True: calibration is the robot's own."""
        return True

    def calibrate(self) -> None:
        """Do nothing: calibration is the robot's own."""

    def configure(self) -> None:
        """Do nothing: configuration is the robot's own."""

    # Any: as lerobot's.
    def get_observation(self) -> dict[str, Any]:
        """Return the newest positions, and the newest image of each camera as RGB.

        Raises:
            UnavailableError: A topic is silent.
        """
        positions = {f"{name}{_SUFFIX}": at for name, at in self._positions.read().items()}
        return {**positions, **self._images.read()}

    # Any: as lerobot's.
    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Send positions to the controllers; return those that were sent.

        Measured joints that no controller moves are passed over, such as a gripper's second
        finger: lerobot-rollout sends the first observation back at its end.

        Raises:
            InvalidParameterError: A position is not finite, or there is no such joint.
            UnavailableError: The joint states are silent.
        """
        measured = self._positions.read()
        positions = {}
        for name, value in action.items():
            joint, wanted = name.removesuffix(_SUFFIX), float(value)
            if name not in self.action_features and name in self.observation_features:
                continue
            if name not in self.action_features:
                raise InvalidParameterError(
                    f"No active controller moves '{joint}'",
                    hint=f"They move {', '.join(self.action_features)}.",
                )
            if not abs(wanted) < float("inf"):
                raise InvalidParameterError(f"The action for '{joint}' is {wanted}")
            if (most := self.config.max_step) > 0.0 and joint in measured:
                wanted = min(max(wanted, measured[joint] - most), measured[joint] + most)
            positions[joint] = wanted
        if self.config.sends_actions:
            for publisher in self._publishers:
                publisher.publish(positions, {}, measured)
        return {f"{joint}{_SUFFIX}": value for joint, value in positions.items()}

    def disconnect(self) -> None:
        """Leave the graph; the controllers hold the joints."""
        self._is_connected = False
        self._exit.close()
