"""Base class of displays, and the interface of the viewer's node that they use.

A display has the properties of the same display in RViz. It is subscribed only while it is enabled
and a browser shows the page. Faults appear as one status in the list of displays, not as many log
lines.

All methods are called on the node's thread, so a display needs no locks. Long tasks, such as
reading files, are passed to `Stage.run_in_background` in another thread.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from teleopctl.errors import TeleopctlError
from teleopctl.node import DurabilityPolicy
from teleopctl.viewer.displays.properties import Properties, Property

if TYPE_CHECKING:
    import viser

    from teleopctl.node import Node, QoSProfile
    from teleopctl.tf import Transform
    from teleopctl.viewer.scene.frames import SceneFrames

OK = "ok"
WARN = "warn"
ERROR = "error"

# Any: messages, whose classes are created from definitions at run time.


class Stage(Protocol):
    """Interface of the viewer's node that displays use: scene, GUI, tf frames, subscriptions."""

    @property
    def node(self) -> Node:
        """The viewer's ROS node, for its clock, clients and logger."""

    @property
    def scene(self) -> viser.SceneApi:
        """The viser scene in which displays draw."""

    @property
    def gui(self) -> viser.GuiApi:
        """The viser GUI, for windows beside the 3D view."""

    @property
    def frames(self) -> SceneFrames:
        """The tf frames as nodes of the scene, with their poses in the fixed frame."""

    @property
    def robot_folder(self) -> Path | None:
        """Folder of the robot's description file; None if unknown."""

    def camera(self) -> Transform | None:
        """Return the fixed-frame pose of the camera moved last (x ahead); None without browsers.

        With several browsers, the camera that was moved last; None before a browser has connected.
        """

    def on_node_thread(self, function: Callable[..., object]) -> Callable[..., None]:
        """Return a callback for viser that queues a call of ``function`` on the node's thread."""

    def subscribe(
        self, topic: str, type_name: str, callback: Callable[[Any], object], qos: QoSProfile
    ) -> Callable[[], None]:
        """Subscribe to a topic once its type is known; return a function that unsubscribes."""

    def knows_type(self, type_name: str) -> bool:
        """Return whether the definition of a message type is installed or has been received.

        The definition of an unknown type is requested from a node that uses the type; messages are
        received only after the definition.
        """

    def run_in_background(self, task: Callable[[], Any], then: Callable[[Any], object]) -> None:
        """Run a task in another thread; call ``then(result or exception)`` on the node's thread.

        An exception that the task raises is passed as its result.
        """


class Display:
    """Base class of displays: drawings of one topic, or of tf, in the 3D view.

    Attributes:
        rviz_class: Name of the class in ``.rviz`` files, without package.
        message_type: Type of the topic; empty for a display without a topic.
        other_types: Further types that the topic may have.
        properties: Properties of the display, except name, topic and enabled.
        topic_key: Name of the property that holds the topic in an ``.rviz`` file.
        parts_title: Title of the list of `parts`; empty for a display without parts.
        latched: Whether to subscribe as transient local, regardless of the file.
        name: Name of the display in the list of displays.
        topic: Topic to subscribe to; empty while no topic is selected.
        status: Level (`OK`, `WARN` or `ERROR`) and a sentence.
        root: Scene path below which the display draws.
        messages: Number of messages received since the last reset.
        in_shown_group: Whether all groups of the ``.rviz`` file that contain the display are
            enabled.

    Args:
        stage: The viewer's node.
        name: Name of the display in the list of displays.
        root: Scene path below which this display alone draws.
        given: The display's mapping in an ``.rviz`` file, changed when a property is set.
    """

    rviz_class: ClassVar[str]
    message_type: ClassVar[str] = ""
    other_types: ClassVar[tuple[str, ...]] = ()
    properties: ClassVar[tuple[Property, ...]] = ()
    topic_key: ClassVar[str] = "Topic"
    parts_title: ClassVar[str] = ""
    latched: ClassVar[bool] = False

    def __init__(
        self, stage: Stage, name: str, root: str, given: dict[str, Any] | None = None
    ) -> None:
        self.stage = stage
        self.name = name
        self.root = root
        self.values = Properties(self.properties, given)
        self.topic = _topic_of(self.values.given)
        self.status = (OK, "")
        self.messages = 0
        self._end: Callable[[], None] | None = None
        self.in_shown_group = True
        self._drawn = False
        self._logged = ""
        self._prepare()

    # --- called by the viewer -----------------------------------------------------------------

    @property
    def is_enabled(self) -> bool:
        """Whether the display and all groups of the ``.rviz`` file that hold it are enabled."""
        return self.in_shown_group and self.values.given.get("Enabled", True) is not False

    @property
    def is_drawn(self) -> bool:
        """Whether the display is subscribed and drawn at present."""
        return self._drawn

    def begin(self) -> None:
        """Call `started` and subscribe to the topic, unless the display is drawn already."""
        if self._drawn:
            return
        self._drawn = True
        self._start()

    def end(self) -> None:
        """Unsubscribe, and call `stopped`, which removes everything from the scene."""
        if not self._drawn:
            return
        self._drawn = False
        self._unsubscribe()
        self.stopped()

    def update(self, *, jumped_back: bool) -> None:
        """Call `time_jumped_back` if ROS time jumped back, then `tick`, if the display is drawn.

        Called by the viewer for each picture.

        Args:
            jumped_back: Whether the node's time is earlier than at the last call.
        """
        if not self._drawn:
            return
        if jumped_back:
            self._guarded(self.time_jumped_back)
        self._guarded(self.tick)

    def set_topic(self, topic: str) -> None:
        """Set the topic, also in the ``.rviz`` mapping; if drawn, clear and subscribe again."""
        self.topic = topic
        place = self.values.given.get(self.topic_key)
        if isinstance(place, dict):
            place["Value"] = topic
        else:
            self.values.given[self.topic_key] = {"Value": topic}
        self.reset()

    def reset(self) -> None:
        """Clear the display and, if drawn, subscribe again, which brings latched messages back."""
        self.messages = 0
        self.status = (OK, "")
        if self._drawn:
            self._unsubscribe()
            self.stopped()
            self._start()

    def set(self, name: str, value: Any) -> None:
        """Set a property in the ``.rviz`` mapping; call `changed` if the display is drawn."""
        self.values.set(name, value)
        if self._drawn:
            self._guarded(lambda: self.changed(name))

    # --- overridden by displays ---------------------------------------------------------------

    def _prepare(self) -> None:
        """Initialise further attributes; called once, at the end of the constructor."""

    def started(self) -> None:
        """Draw what needs no message; called before the display subscribes. Override."""

    def stopped(self) -> None:
        """Remove everything from the scene; called after the display has unsubscribed. Override."""

    def received(self, message: Any) -> None:
        """Handle a message of the display's topic; called on the node's thread.

        Override.
        """

    def changed(self, name: str) -> None:  # noqa: ARG002 -- for overrides
        """Redraw after the property ``name`` was set: by default call `stopped`, then `started`."""
        self.stopped()
        self.started()

    def tick(self) -> None:
        """Update poses and status; called 30 times a second while the display is drawn."""

    def time_jumped_back(self) -> None:
        """Clear drawn messages after ROS time jumped back; subscribe again if latched.

        A latched message from before the jump is not repeated unless the display subscribes again.
        """
        if self._end is not None and self.qos().durability == DurabilityPolicy.TRANSIENT_LOCAL:
            self.reset()
        else:
            self.stopped()
            self.started()

    def parts(self) -> dict[str, bool]:
        """Return whether each part that users can hide, such as a namespace, is shown, by name."""
        return {}

    def parts_text(self) -> str:
        """Return Markdown to show on the page below the list of `parts`; empty for none."""
        return ""

    def show_part(self, name: str, *, shown: bool) -> None:
        """Show one of the `parts`, by its name, if ``shown``, else hide it; for subclasses."""

    # --- for subclasses -----------------------------------------------------------------------

    def subscription_type(self) -> str:
        """Return the type to subscribe to: the publishers' if supported, else `message_type`."""
        known = (self.message_type, *self.other_types)
        if self.other_types:
            offered = [
                one.topic_type for one in self.stage.node.get_publishers_info_by_topic(self.topic)
            ]
            known = next(((name,) for name in known if name in offered), known)
        return known[0]

    def qos(self) -> QoSProfile:
        """Return the subscription's QoS: the ``.rviz`` file's, adapted to the publishers' QoS."""
        from teleopctl.viewer.subscriptions import topic_qos

        return topic_qos(self.stage.node, self.topic, self.values.given, latched=self.latched)

    def set_status(self, level: str, text: str = "") -> None:
        """Set the status in the list of displays: `OK`, `WARN` or `ERROR`, and a sentence."""
        self.status = (level, text)

    def _start(self) -> None:
        def start() -> None:
            self.started()
            self._subscribe()

        # The topic in a file may be an invalid name.
        self._guarded(start)

    def _subscribe(self) -> None:
        if self.topic and self.message_type:
            kind = self.subscription_type()
            if not self.stage.knows_type(kind):
                self.set_status(
                    WARN, f"{kind} is not known; requesting it from a node that uses it"
                )
            self._end = self.stage.subscribe(self.topic, kind, self._receive, self.qos())

    def _unsubscribe(self) -> None:
        if self._end is not None:
            self._end()
            self._end = None

    def _receive(self, message: Any) -> None:
        if not self._drawn:
            return
        self.messages += 1
        self.set_status(OK)
        self._guarded(lambda: self.received(message))

    def _guarded(self, function: Callable[[], object]) -> None:
        """Call a function, and show its exception as the display's status; others continue."""
        try:
            function()
        except TeleopctlError as error:
            # Messages of several lines may end with a caret below a column of the line above.
            self._report_fault(" ".join(error.message.split()).removesuffix(" ^"))
        except Exception as error:  # noqa: BLE001 -- other displays must still be drawn
            self._report_fault(f"{type(error).__name__}: {error}")

    def _report_fault(self, reason: str) -> None:
        """Set the status to a fault, and log it unless it is the one logged last."""
        self.set_status(ERROR, reason)
        if reason != self._logged:
            self._logged = reason
            self.stage.node.get_logger().warning(
                f"Display '{self.name}' cannot be drawn: {reason}", throttle_duration_sec=10.0
            )


def _topic_of(given: dict[str, Any]) -> str:
    """Return the topic in an ``.rviz`` file's mapping, of RViz for ROS 2 or ROS 1."""
    for key in ("Topic", "Marker Topic", "Image Topic", "Description Topic"):
        value = given.get(key)
        if isinstance(value, dict):
            value = value.get("Value")
        if isinstance(value, str) and value:
            return value
    return ""
