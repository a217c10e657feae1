"""What a display is: something of the graph, drawn in the picture while it is enabled.

A display has the properties that RViz's has, listens only while it is drawn for somebody, and says
how it fares: one status with its cause, in the place of a flood of log lines.

All methods are called on the node's thread, so a display needs no locks. What takes long, such as
reading files, is given to `Stage.work` in another thread.
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

# Any stands for messages throughout: their classes are made at run time, from definitions.


class Stage(Protocol):
    """The parts of the viewer's node that displays use."""

    @property
    def node(self) -> Node:
        """The viewer's node, for its clock, clients and logger."""

    @property
    def scene(self) -> viser.SceneApi:
        """The viser scene to draw in."""

    @property
    def gui(self) -> viser.GuiApi:
        """The viser GUI, for windows beside the 3D view."""

    @property
    def frames(self) -> SceneFrames:
        """The tf frames and their poses."""

    @property
    def robot_folder(self) -> Path | None:
        """Folder of the robot's description file; None if unknown."""

    def camera(self) -> Transform | None:
        """Return the camera's pose in the fixed frame (x ahead, y left, z up), or None.

        Of several people it is the one who has turned the view last; None while nobody has looked.
        """

    def on(self, function: Callable[..., object]) -> Callable[..., None]:
        """Wrap a function for viser's callbacks, so that it runs on the node's thread."""

    def subscribe(
        self, topic: str, type_name: str, callback: Callable[[Any], object], qos: QoSProfile
    ) -> Callable[[], None]:
        """Subscribe to a topic; return a function that ends the subscription."""

    def knows(self, type_name: str) -> bool:
        """Return whether a message type is known on this machine.

        One that is not is learned from a node that uses it, if there is one; until then nothing
        is received.
        """

    def work(self, task: Callable[[], Any], then: Callable[[Any], object]) -> None:
        """Run a long task in another thread, and pass its result to ``then``.

        ``then`` is called on the node's thread. An exception of the task is its result.
        """


class Display:
    """Base of displays.

    Attributes:
        rviz_class: The class's name in ``.rviz`` files, without its package.
        message_type: What it listens to; empty for one that is not about one topic.
        other_types: What it shows besides.
        properties: What can be set, besides name, topic and whether it is enabled.
        topic_key: Under which property a file names its topic.
        parts_title: What its `parts` are called; empty for a display without any.
        latched: Whether the last message counts for those who come late, however the file asks.
        name: What the user calls it.
        topic: Where it listens; empty while nothing has been chosen.
        status: How it fares: `OK`, `WARN` or `ERROR`, and a sentence.
        root: The name in the scene below which it draws.
        messages: How many messages it has taken.
        in_shown_group: Whether the groups that it is in, in a file, are shown.

    Args:
        stage: What it works with.
        name: Its name.
        root: The name in the scene below which it draws; nobody else draws there.
        given: What a file says of it.
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
        self.topic = _topic_in(self.values.given)
        self.status = (OK, "")
        self.messages = 0
        self._end: Callable[[], None] | None = None
        self.in_shown_group = True
        self._drawn = False
        self._logged = ""
        self._prepare()

    # --- what the viewer calls ----------------------------------------------------------------

    @property
    def is_enabled(self) -> bool:
        """Whether the display is enabled, and its group too."""
        return self.in_shown_group and self.values.given.get("Enabled", True) is not False

    @property
    def is_drawn(self) -> bool:
        """Whether the display is subscribed and drawn."""
        return self._drawn

    def begin(self) -> None:
        """Subscribe and draw, until `end`."""
        if self._drawn:
            return
        self._drawn = True
        self._start()

    def end(self) -> None:
        """Unsubscribe and remove everything from the scene."""
        if not self._drawn:
            return
        self._drawn = False
        self._hush()
        self.stopped()

    def follow(self, *, jumped_back: bool) -> None:
        """Update the display for the next picture.

        Args:
            jumped_back: Whether time is earlier than at the last one.
        """
        if not self._drawn:
            return
        if jumped_back:
            self._guarded(self.time_jumped_back)
        self._guarded(self.tick)

    def listen_to(self, topic: str) -> None:
        """Set the topic."""
        self.topic = topic
        place = self.values.given.get(self.topic_key)
        if isinstance(place, dict):
            place["Value"] = topic
        else:
            self.values.given[self.topic_key] = {"Value": topic}
        self.reset()

    def reset(self) -> None:
        """Clear the display and subscribe again, which brings latched messages back."""
        self.messages = 0
        self.status = (OK, "")
        if self._drawn:
            self._hush()
            self.stopped()
            self._start()

    def set(self, name: str, value: Any) -> None:
        """Set a property and redraw."""
        self.values.set(name, value)
        if self._drawn:
            self._guarded(lambda: self.changed(name))

    # --- what a kind of display defines -------------------------------------------------------

    def _prepare(self) -> None:
        """Make what the display keeps besides; called once, at the end of the constructor."""

    def started(self) -> None:
        """Draw what needs no message."""

    def stopped(self) -> None:
        """Remove everything from the scene."""

    def received(self, message: Any) -> None:
        """Handle a message."""

    def changed(self, name: str) -> None:  # noqa: ARG002 -- for those who ask which one
        """Redraw after a property was set; by default by stopping and starting the display."""
        self.stopped()
        self.started()

    def tick(self) -> None:
        """Update poses; called once per picture while a browser shows the page."""

    def time_jumped_back(self) -> None:
        """Drop messages with stamps in the future, after time has jumped back.

        A latched message may have come before the clock went back, and will not come again: it is
        asked for once more.
        """
        if self._end is not None and self.qos().durability == DurabilityPolicy.TRANSIENT_LOCAL:
            self.reset()
        else:
            self.stopped()
            self.started()

    def parts(self) -> dict[str, bool]:
        """Return the parts that can be shown one by one, by name, with their visibility."""
        return {}

    def parts_text(self) -> str:
        """Return Markdown shown beside the parts; empty for none."""
        return ""

    def show_part(self, name: str, *, shown: bool) -> None:
        """Show or hide one of the `parts`."""

    # --- what it uses -------------------------------------------------------------------------

    def type_of_topic(self) -> str:
        """Return the type to subscribe to: that of the topic, if the display supports it."""
        known = (self.message_type, *self.other_types)
        if self.other_types:
            offered = [
                one.topic_type for one in self.stage.node.get_publishers_info_by_topic(self.topic)
            ]
            known = next(((name,) for name in known if name in offered), known)
        return known[0]

    def qos(self) -> QoSProfile:
        """Return the QoS of the subscription: the file's, as far as publishers offer it."""
        from teleopctl.viewer.displays.topic_qos import topic_qos

        return topic_qos(self.stage.node, self.topic, self.values.given, latched=self.latched)

    def say(self, level: str, text: str = "") -> None:
        """Set the display's status."""
        self.status = (level, text)

    def _start(self) -> None:
        def start() -> None:
            self.started()
            self._listen()

        # The topic of a file may have a name that no topic can have.
        self._guarded(start)

    def _listen(self) -> None:
        if self.topic and self.message_type:
            kind = self.type_of_topic()
            if not self.stage.knows(kind):
                self.say(WARN, f"{kind} is not known here; a node that publishes it is asked")
            self._end = self.stage.subscribe(self.topic, kind, self._take, self.qos())

    def _hush(self) -> None:
        if self._end is not None:
            self._end()
            self._end = None

    def _take(self, message: Any) -> None:
        if not self._drawn:
            return
        self.messages += 1
        self.say(OK)
        self._guarded(lambda: self.received(message))

    def _guarded(self, what: Callable[[], object]) -> None:
        """Do something that a strange message may spoil, which must not end the page."""
        try:
            what()
        except TeleopctlError as error:
            # Of several lines, of which the last may point at a place in another.
            self._complain(" ".join(error.message.split()).removesuffix(" ^"))
        except Exception as error:  # noqa: BLE001 -- whatever it is, the others are still drawn
            self._complain(f"{type(error).__name__}: {error}")

    def _complain(self, why: str) -> None:
        """Say what is wrong; in the log once, until it is something else."""
        self.say(ERROR, why)
        if why != self._logged:
            self._logged = why
            self.stage.node.get_logger().warning(
                f"Display '{self.name}' cannot be drawn: {why}", throttle_duration_sec=10.0
            )


def _topic_in(given: dict[str, Any]) -> str:
    """The topic that a file names, in the ways of ROS 2's and ROS 1's RViz."""
    for key in ("Topic", "Marker Topic", "Image Topic", "Description Topic"):
        value = given.get(key)
        if isinstance(value, dict):
            value = value.get("Value")
        if isinstance(value, str) and value:
            return value
    return ""
