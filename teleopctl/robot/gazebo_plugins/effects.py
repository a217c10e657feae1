"""What a plug-in of Gazebo becomes here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from teleopctl.robot.urdf import Pose


@dataclass(frozen=True)
class PluginController:
    """A controller in place of a Gazebo plug-in.

    Attributes:
        name: The controller's, which is the plug-in's.
        type: The controller's type.
        parameters: Of its node.
        remappings: From the controller's own names to the plug-in's.
        joints: The joints that it moves, and the interface of each that it commands.
        efforts: The most that each may exert, N m or N, where the plug-in says so.
    """

    name: str
    type: str
    # Any: parameters have one of nine types.
    parameters: Mapping[str, Any]
    remappings: tuple[str, ...]
    joints: Mapping[str, str]
    efforts: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class GroundTruth:
    """True odometry of a link, to be published by the simulator.

    Attributes:
        name: Of what tells it.
        link: The link.
        frame_id: What its pose is told in; a link's name with ``relative_to`` set.
        child_frame_id: What the link is called.
        topic: Of ``nav_msgs/msg/Odometry``; empty for none.
        tf_topic: Of ``tf2_msgs/msg/TFMessage``; empty for none.
        rate_hz: How often; 0 is each control tick.
        in_child_frame: Whether velocities are along the axes of the link, as REP 105 has them, and
            not along those of the frame.
        relative_to: The link that the frame belongs to; empty for the world.
        offset: Added to the position, and turned by.
        noise: Standard deviation of what is added to velocities, m/s and rad/s.
        pose_variance: Diagonal of the covariance of the pose; likewise of the twist.
        twist_variance: See there.
    """

    name: str
    link: str
    frame_id: str
    child_frame_id: str
    topic: str = ""
    tf_topic: str = ""
    rate_hz: float = 0.0
    in_child_frame: bool = True
    relative_to: str = ""
    offset: Pose = field(default_factory=Pose)
    noise: float = 0.0
    pose_variance: tuple[float, ...] = (0.0,) * 6
    twist_variance: tuple[float, ...] = (0.0,) * 6


@dataclass(frozen=True)
class PluginEffect:
    """Controllers, odometry and topics that a Gazebo plug-in stands for.

    Attributes:
        says: One sentence's end: what it listens to, and tells.
        controller: The controller that moves joints for it, or None.
        truths: Odometry that the simulator publishes for it.
        planar_topics: Topics by whose velocities the simulator moves the base.
    """

    says: str
    controller: PluginController | None = None
    truths: tuple[GroundTruth, ...] = ()
    planar_topics: tuple[str, ...] = ()
