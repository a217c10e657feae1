"""Panel that publishes messages, calls services and sends goals, by a form of the type's fields."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from teleopctl.interfaces import get_action, get_message, get_service, known_types, message_to_yaml
from teleopctl.node import ActionClient
from teleopctl.viewer.html import escaped_html, escaped_html_lines, note_html
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.panels.message_form import MessageForm
from teleopctl.viewer.service_calls import ServiceCalls, is_of_every_node

MOST_OFFERED = 1000

_CHOOSE = "type a part of its name"
_TICKS_PER_LIST = 10
_LONGEST_TEXT = 4000
_LONGEST_LIST = 20
_TIMEOUT_S = 30.0
_DEPTH = 10
_RATES = ("Publish", "at 1 Hz", "at 10 Hz", "Stop")
_TICKS_OF_RATES = {"at 1 Hz": 10, "at 10 Hz": 1}
_STATES = {4: "succeeded", 5: "was canceled", 6: "was aborted"}
_TEXT = (
    '<pre style="margin:0 12px;padding:6px 8px;font-size:11px;line-height:1.35;overflow:auto;'
    'max-height:40vh;border:1px solid #8a94a040;border-radius:4px">{text}</pre>'
)

# Any: messages, whose classes are created from definitions at run time, and viser's handles.


class SendPanel(Panel):
    """Panel that publishes messages, calls services and sends goals, by a form."""

    title: ClassVar[str] = "Send"
    icon = "send"
    is_per_browser = True

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._calls = ServiceCalls(page)
        self._targets: dict[str, tuple[str, str, str]] = {}
        self._target: tuple[str, str, str] | None = None
        self._form: MessageForm | None = None
        self._place: Any = None
        self._publisher: Any = None
        self._action: Any = None
        self._goal: Any = None
        self._period_ticks = self._ticks = 0
        self._is_graph_new = True

    def build(self) -> None:
        """Add the choice of a topic, service or action; its form follows."""
        self._choice: Any = self.gui.add_dropdown(
            "To", (_CHOOSE,), hint="A topic to publish on, a service to call, an action"
        )
        self._choice.on_update(self.page.on_node_thread(self._choose))
        self._where = self.gui.add_folder(None)
        self._answer = self.gui.add_html("")

    def began(self) -> None:
        """Offer what is in the graph; called when a browser shows the panel."""
        self._is_graph_new = True

    def ended(self) -> None:
        """Stop repeated publishing; called when no browser shows the panel any more."""
        self._period_ticks = 0

    def graph_changed(self) -> None:
        """Mark the offered names as outdated, to be updated by a later `tick`."""
        self._is_graph_new = True

    def close(self) -> None:
        """End calls and goals; called when the viewer is destroyed."""
        self._drop()

    def tick(self) -> None:
        """Update the offered names, and publish again if periodic publishing is on."""
        self._ticks += 1
        if self._is_graph_new and self._ticks % _TICKS_PER_LIST in (0, 1):
            self._is_graph_new = False
            self._offer()
        if self._period_ticks and self._ticks % self._period_ticks == 0:
            self._publish()

    def _offer(self) -> None:
        graph = self.page.node.graph()
        found: dict[str, tuple[str, str, str]] = {}
        for kind, names in (
            ("topic", graph.topic_names_and_types()),
            ("service", graph.service_names_and_types()),
            ("action", graph.action_names_and_types()),
        ):
            for name, types in names:
                if not is_of_every_node(name) and types and len(found) < MOST_OFFERED:
                    found[f"{kind} {name}"] = kind, name, types[0]
        self._targets = found
        options = (_CHOOSE, *found)
        chosen = self._choice.value
        if chosen not in options:
            options = (*options, chosen)
        if options != tuple(self._choice.options):
            self._choice.options = options
            self._choice.value = chosen

    # --- the form -----------------------------------------------------------------------------

    def _choose(self, event: Any) -> None:
        # The event of a value that was set by this process has no client.
        if event.client is None:
            return
        self._drop()
        self._target = self._targets.get(event.target.value)
        if self._target is None:
            return
        kind, _, type_name = self._target
        self._place = None
        if known_types().find(type_name) is None and kind == "topic":
            self._say(f"The definition of {escaped_html(type_name)} is not installed here.")
            return
        classes: dict[str, Callable[[], Any]] = {
            "topic": lambda: get_message(type_name),
            "service": lambda: get_service(type_name).Request,
            "action": lambda: get_action(type_name).Goal,
        }
        buttons = {"topic": _RATES, "service": ("Call",), "action": ("Send goal", "Cancel")}
        with self._where, self.gui.add_folder(type_name) as self._place:
            self._form = MessageForm(self.gui, classes[kind]())
            row = self.gui.add_button_group(" ", buttons[kind])
        row.on_click(self.page.on_node_thread(self._press))
        self._say("")

    def _drop(self) -> None:
        """Remove the form, and end all that was begun by it."""
        self._period_ticks = 0
        self._calls.close()
        if self._place is not None:
            self._place.remove()
        if self._publisher is not None:
            self.page.node.destroy_publisher(self._publisher)
        if self._action is not None:
            self._action.destroy()
        self._place = self._form = self._publisher = self._action = self._goal = None

    def _message(self) -> Any:
        assert self._form is not None
        return self._form.message(self.page.node.get_clock().now().nanoseconds)

    def _press(self, event: Any) -> None:
        what = event.target.value
        if self._target is None or self._form is None:
            return
        kind = self._target[0]
        if kind == "service":
            self._call()
        elif what == "Send goal":
            self._send_goal()
        elif what == "Cancel":
            if self._goal is not None:
                self._goal.cancel_goal_async()
        else:
            self._period_ticks = _TICKS_OF_RATES.get(what, 0)
            if what == "Publish":
                self._publish()

    # --- topic, service, action ---------------------------------------------------------------

    def _publish(self) -> None:
        assert self._target is not None
        _, name, type_name = self._target
        try:
            message = self._message()
        except Exception:
            self._period_ticks = 0
            raise
        if self._publisher is None:
            self._publisher = self.page.node.create_publisher(get_message(type_name), name, _DEPTH)
        self._publisher.publish(message)
        receivers = self.page.node.count_subscribers(name)
        self._say(f"Published to {receivers} subscription{'s' * (receivers != 1)}.")

    def _call(self) -> None:
        assert self._target is not None
        _, name, type_name = self._target
        request = self._message()
        fields = {field.attribute: getattr(request, field.attribute) for field in _fields(request)}
        self._say(f"Calling {escaped_html(name)}…")
        self._calls.call(
            name,
            type_name,
            lambda response: self._show(response),
            lambda reason: self._say(escaped_html(reason)),
            timeout_s=_TIMEOUT_S,
            **fields,
        )

    def _send_goal(self) -> None:
        assert self._target is not None
        _, name, type_name = self._target
        on = self.page.on_node_thread
        goal = self._message()
        if self._action is None:
            self._action = ActionClient(self.page.node, get_action(type_name), name)
        action = self._action
        if not action.server_is_ready():
            self._say(f"{escaped_html(name)} has no server")
            return

        def feedback(message: Any) -> None:
            if action is self._action:
                self._show(message.feedback)

        def finished(future: Any) -> None:
            if action is self._action:
                response = future.result()
                state = _STATES.get(response.status, f"ended with status {response.status}")
                self._show(response.result, f"The goal {state}.")

        def accepted(future: Any) -> None:
            if action is not self._action:
                return
            handle = future.result()
            if not handle.accepted:
                self._say("The goal was rejected.")
                return
            self._goal = handle
            self._say("The goal was accepted.")
            handle.get_result_async().add_done_callback(on(finished))

        self._say("Sending the goal…")
        action.send_goal_async(goal, on(feedback)).add_done_callback(on(accepted))

    def _show(self, message: Any, title: str = "") -> None:
        text = message_to_yaml(message, truncate=_LONGEST_LIST)
        content = _TEXT.format(text=escaped_html_lines(text, _LONGEST_TEXT))
        self._answer.content = (note_html(escaped_html(title)) if title else "") + content

    def _say(self, text: str) -> None:
        self._answer.content = note_html(text) if text else ""


def _fields(message: Any) -> Any:
    return message.__definition__.fields
