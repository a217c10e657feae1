"""``camera``: renders a camera sensor of the robot in a process of its own.

Topics out: ``/image_raw`` (rgb8) and ``/camera_info`` at the sensor's rate in simulated time,
stamped with the time of the state that they show; ``/tf_static`` with the optical frame. In:
``/robot_description`` and the simulator's joint states, the latter only while somebody subscribes
to one of the outputs. Nobody subscribed to the image: nothing is drawn.

Parameters: ``robot_description``, ``world`` (the file of what stands around the robot) and
``fixed_base``, both as for the simulator, ``camera`` (name of the sensor, by default the first),
``quality`` (``auto``, ``fast`` or ``full``; can be set while running).
"""

from __future__ import annotations

import array
import contextlib
import threading
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl import progress
from teleopctl.errors import InvalidParameterError
from teleopctl.interfaces import get_message, to_nanoseconds
from teleopctl.node import (
    ExternalShutdownException,
    Node,
    Parameter,
    QoSProfile,
    Subscription,
    init,
    qos_profile_latched,
    spin,
)
from teleopctl.packages import resolve_uri
from teleopctl.robot import RobotDescription, read_world
from teleopctl.sim import check_drawing, choose_backend
from teleopctl.tf import StaticTransformBroadcaster

if TYPE_CHECKING:
    from sensor_msgs.msg import JointState

    # These import mujoco, which has to wait for the choice of its backend.
    from teleopctl.mujoco_model import CameraModel, RobotModel
    from teleopctl.sim import Beat, CameraRenderer

_String = get_message("std_msgs/msg/String")
_JointState = get_message("sensor_msgs/msg/JointState")
_Image = get_message("sensor_msgs/msg/Image")
_CameraInfo = get_message("sensor_msgs/msg/CameraInfo")
_ParameterDescriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")
_SetParametersResult = get_message("rcl_interfaces/msg/SetParametersResult")
_FreeJointStateArray = get_message("mujoco_ros2_control_msgs/msg/FreeJointStateArray")
_TransformStamped = get_message("geometry_msgs/msg/TransformStamped")

_DESCRIPTION_TOPIC = "/robot_description"
_VIEW_TOPIC = "/mujoco_sim/joint_states"
_BODIES_TOPIC = "/mujoco_sim/free_joint_states"
_QUALITIES = ("auto", "fast", "full")


class Camera(Node):
    """The camera's node. Everything that draws happens on one thread, as OpenGL wants it."""

    def __init__(self) -> None:
        progress.tell(progress.STARTING)
        super().__init__("camera")
        at_start = _ParameterDescriptor(read_only=True)
        self.declare_parameter("robot_description", "", at_start)
        self.declare_parameter("world", "", at_start)
        self.declare_parameter("fixed_base", False, at_start)
        self.declare_parameter("camera", "", at_start)
        self._quality = str(self.declare_parameter("quality", "auto").value)
        if self._quality not in _QUALITIES:
            raise InvalidParameterError(
                f"Parameter 'quality' is '{self._quality}'",
                hint=f"It is one of {', '.join(_QUALITIES)}",
            )
        self._changed = threading.Condition()
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._follow_parameters)
        self._stopped = False
        self._urdf = ""
        self._latest: Any = None
        self._bodies: Any = None
        self._bodies_wanted = False
        self._last_ns = 0
        self._states: Subscription[JointState] | None = None
        # There are no stubs of the simulator's own messages.
        self._free_states: Subscription[Any] | None = None
        self._renderer: CameraRenderer | None = None
        self._drawn_quality = self._quality
        self._image_wanted = False
        self._info_wanted = False
        self._thread: threading.Thread | None = None
        self._tf = StaticTransformBroadcaster(self)
        given = str(self.get_parameter("robot_description").value)
        if given:
            self._start(given)
            progress.tell(progress.READY)
        else:
            progress.tell(progress.WAITING, _DESCRIPTION_TOPIC)
            self.create_subscription(
                _String, _DESCRIPTION_TOPIC, self._on_description, qos_profile_latched
            )

    # --- parameters -----------------------------------------------------------------------

    def _check_parameters(self, parameters: list[Parameter]) -> Any:
        for parameter in parameters:
            if parameter.name == "quality" and parameter.value not in _QUALITIES:
                reason = f"quality is one of {', '.join(_QUALITIES)}"
                return _SetParametersResult(successful=False, reason=reason)
        return _SetParametersResult(successful=True)

    def _follow_parameters(self, parameters: list[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == "quality":
                self._quality = str(parameter.value)

    # --- start ----------------------------------------------------------------------------

    def _on_description(self, message: Any) -> None:
        if not self._urdf:
            progress.tell(progress.STARTING)
            self._start(message.data)
            progress.tell(progress.READY)
        elif message.data != self._urdf:
            self.get_logger().warning(
                "Another robot description was published; this camera keeps the first one"
            )

    def _start(self, urdf: str) -> None:
        from teleopctl.mujoco_model import build_model
        from teleopctl.sim import Beat

        description = RobotDescription.from_urdf(urdf)
        self._urdf = urdf
        file = str(self.get_parameter("world").value)
        model = build_model(
            description,
            world=read_world(resolve_uri(file)) if file else None,
            fixed_base=bool(self.get_parameter("fixed_base").value),
        )
        name = str(self.get_parameter("camera").value)
        if not name and not model.cameras:
            self.get_logger().warning(f"The robot '{model.name}' has no camera sensor")
            return
        camera = model.camera(name)
        self._model: RobotModel = model
        self._bodies_wanted = bool(model.free_bodies)
        self._camera: CameraModel = camera
        self._beat: Beat = Beat(camera.rate_hz)
        self._image = _new_image(camera)
        self._info = new_info(camera)
        # The newest picture counts: a slow reader of 9 MB each must not see old ones.
        newest = QoSProfile(depth=1)
        self._image_publisher = self.create_publisher(_Image, "image_raw", newest)
        self._info_publisher = self.create_publisher(_CameraInfo, "camera_info", newest)
        if any(camera.distortion):
            self.get_logger().warning(
                f"The lens distortion of camera '{camera.name}' is not simulated: its images and "
                "its camera_info have none"
            )
        if camera.frame_id not in description.links:
            self._tf.sendTransform(_optical_frame(camera))
        self.get_logger().info(
            f"Camera '{camera.name}': {camera.width}x{camera.height} at {camera.rate_hz:g} Hz, "
            f"frame '{camera.frame_id}'"
        )
        self._thread = threading.Thread(target=self._run, name="rendering", daemon=True)
        self.add_graph_callback(self._on_graph)
        self._on_graph()
        self._thread.start()

    # --- called on the transport's threads ------------------------------------------------

    def _on_graph(self) -> None:
        image = self._image_publisher.get_subscription_count() > 0
        info = self._info_publisher.get_subscription_count() > 0
        with self._changed:
            self._image_wanted = image
            self._info_wanted = info
            self._changed.notify_all()

    def _on_state(self, message: Any) -> None:
        with self._changed:
            self._latest = message
            self._changed.notify_all()

    def _on_bodies(self, message: Any) -> None:
        with self._changed:
            self._bodies = message
            self._changed.notify_all()

    def _is_complete(self) -> bool:
        """Whether joints and free bodies of the same time have come."""
        if self._latest is None or not self._bodies_wanted:
            return self._latest is not None
        return self._bodies is not None and self._bodies.header.stamp == self._latest.header.stamp

    # --- drawing --------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            self._draw_until_stopped()
        except Exception as error:  # noqa: BLE001 - whoever spins raises it
            self.fail(error)

    def _draw_until_stopped(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(self._has_something_to_do)
                if self._stopped:
                    break
                wanted, draw = self._is_wanted(), self._image_wanted
                state = bodies = None
                if self._is_complete():
                    state, self._latest = self._latest, None
                    bodies = self._bodies
            self._listen(wanted)
            if state is not None and wanted and self._is_due(state.header.stamp):
                if draw:
                    self._renderer = self._up_to_date_renderer()
                    self._renderer.draw(
                        dict(zip(state.name, state.position, strict=True)), _poses(bodies)
                    )
                self._publish(state.header.stamp, with_image=draw)
        if self._renderer is not None:
            self._renderer.close()

    def _has_something_to_do(self) -> bool:
        listening = self._states is not None
        return self._stopped or self._is_complete() or self._is_wanted() != listening

    def _listen(self, wanted: bool) -> None:
        """Follow the simulator's state only while somebody looks at what comes of it."""
        if wanted and self._states is None:
            self._states = self.create_subscription(
                _JointState, _VIEW_TOPIC, self._on_state, 1, immediate=True
            )
            if self._bodies_wanted:
                self._free_states = self.create_subscription(
                    _FreeJointStateArray, _BODIES_TOPIC, self._on_bodies, 1, immediate=True
                )
        elif not wanted and self._states is not None:
            self.destroy_subscription(self._states)
            self._states = None
            if self._free_states is not None:
                self.destroy_subscription(self._free_states)
                self._free_states = None

    def _is_due(self, stamp: Any) -> bool:
        now_ns = to_nanoseconds(stamp)
        if now_ns < self._last_ns:
            # Another simulator, which has begun at zero.
            self._beat.restart()
        self._last_ns = now_ns
        return self._beat.take(now_ns)

    def _is_wanted(self) -> bool:
        return self._image_wanted or self._info_wanted

    def _up_to_date_renderer(self) -> CameraRenderer:
        """The renderer of the quality that is wanted now."""
        from teleopctl.sim import make_renderer

        quality = self._quality
        if self._renderer is not None:
            if quality == self._drawn_quality:
                return self._renderer
            self._renderer.close()
            self._renderer = None
        # Drawn straight into the message, whose 9 MB are never copied here.
        shape = (self._camera.height, self._camera.width, 3)
        picture = np.frombuffer(self._image.data, np.uint8).reshape(shape)
        renderer, choice = make_renderer(self._model, self._camera, quality, picture)
        self._drawn_quality = quality
        self.get_logger().info(f"Camera '{self._camera.name}': {choice}")
        return renderer

    def _publish(self, stamp: Any, *, with_image: bool) -> None:
        self._info.header.stamp = stamp
        self._info_publisher.publish(self._info)
        if with_image:
            self._image.header.stamp = stamp
            self._image_publisher.publish(self._image)

    def destroy_node(self) -> None:
        """End drawing, then the node."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()
        if self._thread is not None and self._thread.is_alive():
            self._thread.join()
        super().destroy_node()


def _new_image(camera: CameraModel) -> Any:
    image = _Image(height=camera.height, width=camera.width, encoding="rgb8", step=3 * camera.width)
    image.header.frame_id = camera.frame_id
    image.data = array.array("B", bytes(3 * camera.width * camera.height))
    return image


def _poses(bodies: Any) -> dict[str, tuple[float, ...]]:
    """Position and rotation (w x y z) of each free body of a FreeJointStateArray, by link."""
    poses: dict[str, tuple[float, ...]] = {}
    for state in () if bodies is None else bodies.free_joints:
        p, q = state.pose.pose.position, state.pose.pose.orientation
        poses[state.name] = (p.x, p.y, p.z, q.w, q.x, q.y, q.z)
    return poses


# Any: a class that is made from its definition.
def new_info(camera: CameraModel) -> Any:
    """What sensor_msgs/CameraInfo says of a camera, without a stamp."""
    info = _CameraInfo(
        height=camera.height,
        width=camera.width,
        distortion_model="plumb_bob",
        d=[0.0] * 5,  # pictures are drawn without a lens
        k=camera.intrinsics,
        r=(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        p=camera.projection,
    )
    info.header.frame_id = camera.frame_id
    return info


def _optical_frame(camera: CameraModel) -> Any:
    """The frame that users of ``camera_info`` think in: z forward, x right, y down."""
    transform = _TransformStamped(child_frame_id=camera.frame_id)
    transform.header.frame_id = camera.link
    position, rotation = transform.transform.translation, transform.transform.rotation
    position.x, position.y, position.z = camera.pose.xyz
    rotation.x, rotation.y, rotation.z, rotation.w = camera.optical_rotation
    return transform


def main(args: list[str] | None = None) -> int:
    """Run the camera until it is interrupted.

    Raises:
        TeleopctlError: If a system library for drawing is missing.
    """
    choose_backend()
    check_drawing()
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=args),
        Camera() as node,
    ):
        spin(node)
    return 0
