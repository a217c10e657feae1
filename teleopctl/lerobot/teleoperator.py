"""An arm of the graph as a teleoperator of lerobot's programs: ``--teleop.type=teleopctl``."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from lerobot.teleoperators import Teleoperator, TeleoperatorConfig

from teleopctl.errors import NotFoundError
from teleopctl.lerobot.hand import HandProcess, reference_topics
from teleopctl.lerobot.newest import NewestPositions
from teleopctl.node import Node, open_node

_SUFFIX = ".pos"
_LEADER = "/leader/joint_states"


@TeleoperatorConfig.register_subclass("teleopctl")
@dataclass(kw_only=True)
class TeleopctlTeleoperatorConfig(TeleoperatorConfig):
    """Configuration of a teleoperator; the domain is that of ``ROS_DOMAIN_ID``.

    Attributes:
        topics: Topics of positions: the joint states of a leader arm, or the states of the
            controllers that a device drives through servo, with their references. Empty for
            ``/leader/joint_states``, or with a device for all controllers.
        device: Teleop device that drives the robot through servo meanwhile, such as ``gamepad``;
            empty for none. The robot's ``sends_actions`` is to be false then.
        mapping: Name or file of the device's mapping; empty for its own.
        joints: Names of the follower's joints by those of the topics; empty for the same names.
        signs: Factors of joints that turn the other way, by the topics' names.
    """

    topics: list[str] = field(default_factory=list)
    device: str = ""
    mapping: str = ""
    joints: dict[str, str] = field(default_factory=dict)
    signs: dict[str, float] = field(default_factory=dict)


class TeleopctlTeleoperator(Teleoperator):
    """Teleoperator that reads positions from topics, rad or m.

    Args:
        config: Configuration of the teleoperator.
    """

    config_class = TeleopctlTeleoperatorConfig
    name = "teleopctl"

    def __init__(self, config: TeleopctlTeleoperatorConfig) -> None:
        super().__init__(config)
        self.config = config
        self._exit = ExitStack()
        self._is_connected = False
        self._hand: HandProcess | None = None

    @cached_property
    def _node(self) -> Node:
        return self._exit.enter_context(open_node("lerobot_teleoperator"))

    @cached_property
    def _sources(self) -> list[NewestPositions]:
        topics = self.config.topics
        if not topics:
            topics = reference_topics(self._node) if self.config.device else [_LEADER]
        return [NewestPositions(self._node, topic) for topic in topics]

    # Any: as lerobot's.
    @cached_property
    def action_features(self) -> dict[str, Any]:
        """Type of each position."""
        return dict.fromkeys(self.get_action(), float)

    # Any: as lerobot's.
    @property
    def feedback_features(self) -> dict[str, Any]:
        """Empty: there is no feedback."""
        return {}

    @property
    def is_connected(self) -> bool:
        """Whether `connect` was called."""
        return self._is_connected

    def connect(self, calibrate: bool = True) -> None:
        """Wait until all topics have had a message.

        Raises:
            UnavailableError: A topic is silent.
            NotFoundError: A joint that the configuration names is on no topic.
        """
        del calibrate
        if self.config.device and self._hand is None:
            self._hand = HandProcess(self.config.device, self.config.mapping)
            self._exit.callback(self._hand.stop)
        known = {name for source in self._sources for name in source.read()}
        for name in (*self.config.joints, *self.config.signs):
            if name not in known:
                raise NotFoundError(
                    f"No topic has the joint '{name}'",
                    hint=f"They have {', '.join(sorted(known))}.",
                )
        self._is_connected = True

    @property
    def is_calibrated(self) -> bool:
        """True: calibration is the arm's own."""
        return True

    def calibrate(self) -> None:
        """Do nothing: calibration is the arm's own."""

    def configure(self) -> None:
        """Do nothing: configuration is the arm's own."""

    def get_action(self) -> dict[str, float]:
        """Return the newest positions by the follower's names.

        Raises:
            UnavailableError: A topic is silent, or the device has ended.
        """
        if self._hand is not None:
            self._hand.check()
        config = self.config
        action = {}
        for source in self._sources:
            for name, position in source.read().items():
                if config.joints and name not in config.joints:
                    continue
                sign = config.signs.get(name, 1.0)
                action[f"{config.joints.get(name, name)}{_SUFFIX}"] = sign * position
        return action

    # Any: as lerobot's.
    def send_feedback(self, feedback: dict[str, Any]) -> None:
        """Do nothing: there is no feedback."""

    def disconnect(self) -> None:
        """Leave the graph, and end the device."""
        self._is_connected, self._hand = False, None
        self._exit.close()
