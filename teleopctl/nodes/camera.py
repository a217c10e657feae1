"""``camera``: renders the camera sensors of the robot in a process of its own.

Published topics, at each sensor's rate in simulated time and with the stamp of the shown state:
images, depths, points, labels and ``camera_info`` on the topics of `camera_topics`, with
image_transport's ``compressed`` and ``compressedDepth``; ``/tf_static`` with the optical frames.
Subscribed topics: ``/robot_description``, the simulator's model, which changes when objects are
spawned or deleted, and, while an output has a subscriber, the simulator's joint states. Outputs
without a subscriber are not rendered.

Parameters: ``robot_description``, ``world`` (file of the world around the robot), ``fixed_base``,
``spawn_pose`` and ``seed``, as for the simulator, ``camera`` (name of one sensor, default all),
and, settable at runtime, ``quality`` (``auto``, ``fast`` or ``full``), ``compressed.format``
(``jpeg`` or ``png``) and ``compressed.jpeg_quality``.
"""

from __future__ import annotations

import contextlib
import threading
from typing import TYPE_CHECKING, Any

from teleopctl.base import progress
from teleopctl.errors import InvalidMessageError, InvalidParameterError
from teleopctl.interfaces import get_message, to_nanoseconds
from teleopctl.node import (
    ExternalShutdownException,
    Node,
    Parameter,
    Subscription,
    init,
    qos_profile_latched,
    spin,
)
from teleopctl.packages import resolve_uri
from teleopctl.robot import RobotDescription, read_world
from teleopctl.sim import (
    base_settings,
    check_drawing,
    choose_backend,
    declare_base_settings,
)
from teleopctl.tf import StaticTransformBroadcaster
from teleopctl.wire import EntityKind

if TYPE_CHECKING:
    from sensor_msgs.msg import JointState

    # These modules import mujoco, whose rendering backend has to be chosen before.
    from teleopctl.mujoco_model import CameraModel, RobotModel
    from teleopctl.sim import CameraPublishers, CameraRenderer

_String = get_message("std_msgs/msg/String")
_JointState = get_message("sensor_msgs/msg/JointState")
_ParameterDescriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")
_SetParametersResult = get_message("rcl_interfaces/msg/SetParametersResult")
_FreeJointStateArray = get_message("mujoco_ros2_control_msgs/msg/FreeJointStateArray")
_Bytes = get_message("std_msgs/msg/UInt8MultiArray")
_TransformStamped = get_message("geometry_msgs/msg/TransformStamped")

_DESCRIPTION_TOPIC = "/robot_description"
_VIEW_TOPIC = "/mujoco_sim/joint_states"
_BODIES_TOPIC = "/mujoco_sim/free_joint_states"
# Longest wait for the simulator at the start, in seconds of wall time.
_LONGEST_WAIT_S = 3.0
# Parameters that can be set at runtime, with their allowed values.
_CHOICES = {"quality": ("auto", "fast", "full"), "compressed.format": ("jpeg", "png")}


class CameraNode(Node):
    """Node ``camera``, which renders and publishes the camera sensors of a robot.

    All drawing happens on one thread, as OpenGL requires.
    """

    def __init__(self) -> None:
        progress.report(progress.STARTING)
        super().__init__("camera")
        at_start = _ParameterDescriptor(read_only=True)
        self.declare_parameter("robot_description", "", at_start)
        self.declare_parameter("world", "", at_start)
        declare_base_settings(self)
        self.declare_parameter("camera", "", at_start)
        self.declare_parameter("seed", 0, at_start)
        for name, choices in _CHOICES.items():
            value = self.declare_parameter(name, choices[0]).value
            if value not in choices:
                raise InvalidParameterError(
                    f"Parameter '{name}' is '{value}'", hint=f"Expected one of {', '.join(choices)}"
                )
        self.declare_parameter("compressed.jpeg_quality", 95)
        self._changed = threading.Condition()
        self.add_on_set_parameters_callback(self._check_parameters)
        self._stopped = False
        self._urdf = ""
        self._latest: Any = None
        self._bodies: Any = None
        self._bodies_wanted = False
        self._last_ns = 0
        self._states: Subscription[JointState] | None = None
        # The simulator's own messages have no type stubs.
        self._free_states: Subscription[Any] | None = None
        self._channels: list[CameraPublishers] = []
        self._renderer: CameraRenderer | None = None
        # Whether the renderer was created for the present model.
        self._is_current = True
        self._changed_model: Any = None
        # Quality and camera names that the renderer was created for.
        self._drawn_for: tuple[object, frozenset[str]] = ("", frozenset())
        self._thread: threading.Thread | None = None
        self._tf = StaticTransformBroadcaster(self)
        given = str(self.get_parameter("robot_description").value)
        if given:
            self._start(given)
            progress.report(progress.READY)
        else:
            description = self.create_subscription(
                _String, _DESCRIPTION_TOPIC, self._on_description, qos_profile_latched
            )
            progress.report(progress.WAITING, description.topic_name)

    # --- parameters -----------------------------------------------------------------------

    def _check_parameters(self, parameters: list[Parameter]) -> Any:
        for parameter in parameters:
            choices = _CHOICES.get(parameter.name)
            if choices is not None and parameter.value not in choices:
                reason = f"{parameter.name} is one of {', '.join(choices)}"
                return _SetParametersResult(successful=False, reason=reason)
        return _SetParametersResult(successful=True)

    # --- start ----------------------------------------------------------------------------

    def _on_description(self, message: Any) -> None:
        if not self._urdf:
            progress.report(progress.STARTING)
            self._start(message.data)
            progress.report(progress.READY)
        elif message.data != self._urdf:
            self.get_logger().warning(
                "Another robot description was published; this camera keeps the first one"
            )

    def _start(self, urdf: str) -> None:
        description = RobotDescription.from_urdf(urdf)
        self._urdf = urdf
        name = str(self.get_parameter("camera").value)
        if not name and all(sensor.camera is None for sensor in description.gazebo.sensors):
            # No model is built: the simulator needs the CPU to build its own.
            self._warn_no_camera(description)
            return
        # The simulator needs the CPU to start; without one, there is nothing to draw.
        self.wait_for_match(
            EntityKind.MP,
            self.resolve_topic_name(_VIEW_TOPIC),
            _JointState.TYPE_NAME,
            1,
            _LONGEST_WAIT_S,
        )
        import mujoco

        from teleopctl.mujoco_model import build_model
        from teleopctl.sim import MODEL_TOPIC, CameraPublishers

        # Without a handler, MuJoCo writes its warnings to a file in the current folder.
        mujoco.set_mju_user_warning(lambda text: self.get_logger().warning(f"MuJoCo: {text}"))

        file = str(self.get_parameter("world").value)
        model = build_model(
            description,
            world=read_world(resolve_uri(file)) if file else None,
            **base_settings(self),
        )
        if not name and not model.cameras:
            self._warn_no_camera(description)
            return
        self._described = self._model = model
        self._bodies_wanted = bool(model.free_bodies)
        cameras = (model.camera(name),) if name else model.cameras
        for camera in cameras:
            seed = int(self._setting("seed"))
            names = _bodies_of(model)
            self._channels.append(CameraPublishers(self, camera, names, self._setting, seed))
            self.get_logger().info(
                f"Camera '{camera.name}': {camera.width}x{camera.height} at {camera.rate_hz:g} Hz, "
                f"frame '{camera.frame_id}'"
            )
        frames = {camera.frame_id: camera for camera in cameras}
        self._tf.sendTransform(
            [_optical_frame(c) for frame, c in frames.items() if frame not in description.links]
        )
        self.create_subscription(
            _Bytes, MODEL_TOPIC, self._on_model, qos_profile_latched, immediate=True
        )
        self._thread = threading.Thread(target=self._run, name="rendering", daemon=True)
        self.add_graph_callback(self._on_graph)
        self._on_graph()
        self._thread.start()

    def _warn_no_camera(self, description: RobotDescription) -> None:
        self.get_logger().warning(f"The robot '{description.name}' has no camera sensor")

    # --- called on the transport's threads ------------------------------------------------

    def _setting(self, name: str) -> Any:
        return self.get_parameter(name).value

    def _on_graph(self) -> None:
        with self._changed:
            for channel in self._channels:
                channel.on_graph_change()
            self._changed.notify_all()

    def _on_state(self, message: Any) -> None:
        with self._changed:
            self._latest = message
            self._changed.notify_all()

    def _on_bodies(self, message: Any) -> None:
        with self._changed:
            self._bodies = message
            self._changed.notify_all()

    def _on_model(self, message: Any) -> None:
        with self._changed:
            self._changed_model = message
            self._changed.notify_all()

    def _is_complete(self) -> bool:
        """Return whether joint states and free bodies of the same time have been received."""
        if self._latest is None or not self._bodies_wanted:
            return self._latest is not None
        return self._bodies is not None and self._bodies.header.stamp == self._latest.header.stamp

    # --- drawing --------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            self._draw_until_stopped()
        except Exception as error:  # noqa: BLE001 - raised again where the node spins
            self.fail(error)

    def _draw_until_stopped(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(self._has_work)
                if self._stopped:
                    break
                wanted = self._is_wanted()
                changed, self._changed_model = self._changed_model, None
                state = bodies = None
                if self._is_complete():
                    state, self._latest = self._latest, None
                    bodies = self._bodies
            if changed is not None:
                self._take(changed)
            self._listen(wanted)
            if state is not None and wanted:
                self._publish(state, bodies)
        if self._renderer is not None:
            self._renderer.close()

    def _has_work(self) -> bool:
        listening = self._states is not None
        return (
            self._stopped
            or self._changed_model is not None
            or self._is_complete()
            or self._is_wanted() != listening
        )

    def _take(self, message: Any) -> None:
        """Use the model that the simulator has published."""
        from teleopctl.sim import model_from_message

        try:
            model = model_from_message(message, self._described)
        except InvalidMessageError as error:
            self.get_logger().warning(f"Spawned objects are not drawn: {error.message}")
            return
        if model is self._model:
            return
        self._model, self._is_current = model, False
        with self._changed:
            self._bodies_wanted = bool(model.free_bodies)
        for channel in self._channels:
            channel.name_bodies(_bodies_of(model))

    def _listen(self, wanted: bool) -> None:
        """Subscribe to the simulator's state while an output has a subscriber, else unsubscribe."""
        if wanted and self._states is None:
            self._states = self.create_subscription(
                _JointState, _VIEW_TOPIC, self._on_state, 1, immediate=True
            )
            # Free bodies may be spawned later.
            self._free_states = self.create_subscription(
                _FreeJointStateArray, _BODIES_TOPIC, self._on_bodies, 1, immediate=True
            )
        elif not wanted and self._states is not None and self._free_states is not None:
            self.destroy_subscription(self._states)
            self.destroy_subscription(self._free_states)
            self._states = self._free_states = None

    def _publish(self, state: Any, bodies: Any) -> None:
        """Publish the outputs that are due at the time of a state."""
        now_ns = to_nanoseconds(state.header.stamp)
        if now_ns < self._last_ns:
            # Another simulator has started, at time zero.
            for channel in self._channels:
                channel.schedule.restart()
        self._last_ns = now_ns
        due = [channel for channel in self._channels if channel.schedule.poll(now_ns)]
        drawing = [channel for channel in due if channel.draws]
        renderer = self._up_to_date_renderer(drawing) if drawing else None
        if renderer is not None:
            renderer.place(dict(zip(state.name, state.position, strict=True)), _poses(bodies))
        for channel in due:
            channel.publish(renderer if channel in drawing else None, now_ns)

    def _is_wanted(self) -> bool:
        return any(channel.wanted for channel in self._channels)

    def _up_to_date_renderer(self, drawing: list[CameraPublishers]) -> CameraRenderer:
        """Return the renderer for the present ``quality``, for at least these cameras."""
        from teleopctl.sim import CameraRenderer, make_renderer

        quality, drawn = self._drawn_for
        wanted = self._setting("quality")
        names = drawn | {channel.camera.name for channel in drawing}
        cameras = [c.camera for c in self._channels if c.camera.name in names]
        is_current, self._is_current = self._is_current, True
        if self._renderer is not None:
            as_before = quality == wanted and names == drawn
            if as_before and is_current:
                return self._renderer
            found = self._renderer.quality
            self._renderer.close()
            self._renderer = None
            if as_before:
                # The quality was measured once; measuring again would delay images.
                self._renderer = CameraRenderer(self._model, cameras, found)
                return self._renderer
        self._renderer, choice = make_renderer(self._model, cameras, str(wanted))
        self._drawn_for = (wanted, names)
        listed = ", ".join(f"'{camera.name}'" for camera in cameras)
        self.get_logger().info(f"Camera{'s' if len(cameras) > 1 else ''} {listed}: {choice}")
        return self._renderer

    def destroy_node(self) -> None:
        """Stop the rendering thread, and destroy the node."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()
        if self._thread is not None and self._thread.is_alive():
            self._thread.join()
        super().destroy_node()


def _poses(bodies: Any) -> dict[str, tuple[float, ...]]:
    """Position and rotation (w x y z) of each free body of a FreeJointStateArray, by link."""
    poses: dict[str, tuple[float, ...]] = {}
    for state in () if bodies is None else bodies.free_joints:
        p, q = state.pose.pose.position, state.pose.pose.orientation
        poses[state.name] = (p.x, p.y, p.z, q.w, q.x, q.y, q.z)
    return poses


def _bodies_of(model: RobotModel) -> tuple[str, ...]:
    """The names of a model's bodies by their number."""
    mj = model.mj_model
    return tuple(mj.body(number).name for number in range(mj.nbody))


def _optical_frame(camera: CameraModel) -> Any:
    """Return the transform of a camera's optical frame (REP 103): z forward, x right, y down."""
    transform = _TransformStamped(child_frame_id=camera.frame_id)
    transform.header.frame_id = camera.link
    position, rotation = transform.transform.translation, transform.transform.rotation
    position.x, position.y, position.z = camera.pose.xyz
    rotation.x, rotation.y, rotation.z, rotation.w = camera.optical_rotation
    return transform


def main(args: list[str] | None = None) -> int:
    """Run the node ``camera`` until Ctrl-C or a shutdown, and return the exit status.

    Raises:
        TeleopctlError: A system library for rendering is missing.
    """
    choose_backend()
    check_drawing()
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=args, publishes_after_signal=True),
        CameraNode() as node,
    ):
        spin(node)
    return 0
