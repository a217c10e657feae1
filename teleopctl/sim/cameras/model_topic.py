"""Topic of the simulator's compiled model, from which camera processes render spawned entities.

The message contains the model in MuJoCo's binary format (MJB), as of its last change. An empty
message means that the model is the initial one of the robot's and the world's descriptions.
"""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces import get_message
from teleopctl.mujoco_model import FreeBody
from teleopctl.node import qos_profile_latched

if TYPE_CHECKING:
    from teleopctl.mujoco_model import RobotModel
    from teleopctl.node import Node

# A hidden topic, which a bag of all topics leaves out: meshes make a message tens of megabytes.
MODEL_TOPIC = "/mujoco_sim/_model"
_FILE = "model.mjb"

_Bytes = get_message("std_msgs/msg/UInt8MultiArray")


class ModelPublisher:
    """Publisher of the simulation's compiled MuJoCo model, for camera processes.

    Args:
        node: Node of the publisher.
    """

    def __init__(self, node: Node) -> None:
        self._publisher = node.create_publisher(_Bytes, MODEL_TOPIC, qos_profile_latched)
        self._model: RobotModel | None = None
        self._readers = 0
        # The threads of the loop and of the graph publish: the last message must be the newest.
        self._sending = threading.Lock()

    def replace_model(self, model: RobotModel) -> None:
        """Set the model to publish; publish it at once only if there are subscribers."""
        self._model = model
        if self._publisher.get_subscription_count() > 0:
            self._publish()

    def on_graph_change(self) -> None:
        """Publish the model again if there are new subscribers; called when the graph changed."""
        before, self._readers = self._readers, self._publisher.get_subscription_count()
        if self._readers > before:
            self._publish()

    def _publish(self) -> None:
        with self._sending:
            message = _Bytes()
            if self._model is not None:
                m = self._model.mj_model
                data = np.zeros(mujoco.mj_sizeModel(m), np.uint8)
                mujoco.mj_saveModel(m, None, data)
                message.data = data
            self._publisher.publish(message)


# Any: a message, whose class is made at run time.
def model_from_message(message: Any, described: RobotModel) -> RobotModel:
    """Return the robot model in a model message; the initial ``described`` if the message is empty.

    Args:
        message: A UInt8MultiArray.
        described: The model of the robot and its world at the start.

    Raises:
        InvalidMessageError: The message is not a model, or a model of another version of MuJoCo or
            of another robot.
    """
    data = bytes(message.data)
    if not data:
        return described
    try:
        model = mujoco.MjModel.from_binary_path(_FILE, {_FILE: data})
        mujoco.MjData(model)  # fails if the model needs too much memory
    except (ValueError, mujoco.FatalError) as error:
        raise InvalidMessageError(f"{MODEL_TOPIC}: {error}") from error
    for kind, names in (
        (mujoco.mjtObj.mjOBJ_CAMERA, [camera.name for camera in described.cameras]),
        (mujoco.mjtObj.mjOBJ_JOINT, [joint.ball or joint.name for joint in described.joints]),
    ):
        if any(mujoco.mj_name2id(model, kind, name) < 0 for name in names):
            raise InvalidMessageError(f"{MODEL_TOPIC}: it describes another robot")
    known = {body.link: body for body in described.free_bodies}
    free = []
    for number in np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE):
        link = model.body(model.jnt_bodyid[number]).name
        later = FreeBody(link, model.joint(number).name, described.world_frame)
        free.append(known.get(link, later))
    return replace(described, mj_model=model, free_bodies=tuple(free))
