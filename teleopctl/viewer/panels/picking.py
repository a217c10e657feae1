"""Window of a clicked link: its names, joint and place, and what can be done with it."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from teleopctl.node import qos_profile_sensor_data
from teleopctl.robot import Joints
from teleopctl.viewer.html import escaped_html, note_html
from teleopctl.viewer.panels.base import dialog
from teleopctl.viewer.panels.joint_movers import STATES_TOPIC

if TYPE_CHECKING:
    from teleopctl.viewer.displays.robot_model import RobotModelDisplay
    from teleopctl.viewer.panels.base import Page

_CONTACTS = "ros_gz_interfaces/msg/Contacts"
# The forces of a window are shown at most this often, and for this time.
_PERIOD_S, _LONGEST_S = 0.2, 600.0
_NOISE = 1e-9
_WORDS = re.compile(r"::|/")

# Any: messages, whose classes are created from definitions at run time, and viser's handles.


class Picking:
    """Clicks on the links of the robots in the scene.

    Args:
        page: The viewer's node.
    """

    def __init__(self, page: Page) -> None:
        self._page = page

    def open(self, client: Any, robot: RobotModelDisplay, link: str) -> None:
        """Open the window of a link in the browser in which it was clicked.

        Args:
            client: viser's handle of the browser.
            robot: Display of the link's robot.
            link: Name of the link.
        """
        page, view, frame = self._page, self._page.scene_view, robot.frame_of(link)
        joint = _joint_above(robot, link)
        acts: dict[str, Callable[[], object]] = {
            "Stop following" if view.followed(client.client_id) == frame else "Follow": partial(
                view.follow,
                client.client_id,
                "" if view.followed(client.client_id) == frame else frame,
            ),
            "Trace": partial(view.add, "Trace", f"Trace of {frame}", {"Frame": frame}),
            "Axes": partial(view.add, "Axes", f"Axes of {frame}", _axes_of(frame)),
            "Hide": partial(robot.show_link, link, shown=False),
        }
        if joint:
            acts["Slider"] = partial(
                page.workspace.set_open, client.client_id, "joints", is_open=True
            )
            acts["Plot"] = partial(page.workspace.plot_joint, client.client_id, joint)
        if robot.hidden_links():
            acts["Show all links"] = partial(self._show_all, robot)
        with dialog(client, link) as window:
            client.gui.add_html(note_html(self._text(robot, link)))
            forces = client.gui.add_html("", visible=False)
            buttons = client.gui.add_button_group(" ", tuple(acts))

        def press(event: Any) -> None:
            window.close()
            acts[event.target.value]()

        buttons.on_click(page.on_node_thread(press))
        live: dict[str, str] = {"joint": "", "contacts": ""}

        def show(what: str, content: str) -> None:
            if live[what] != content:
                live[what] = content
                forces.content = note_html("<br>".join(filter(None, live.values())))
                forces.visible = True

        if joint:
            self._show_joint(window, partial(show, "joint"), joint)
        self._show_contacts(window, partial(show, "contacts"), link)

    def _while_open(
        self, window: Any, topic: str, kind: str, text_of: Callable[[Any], str | None], show: Any
    ) -> None:
        """Show a text of the newest message of a topic while a window is open."""
        begun_s = shown_s = time.monotonic()

        def take(message: Any) -> None:
            nonlocal shown_s
            now_s = time.monotonic()
            if window.closed or now_s - begun_s > _LONGEST_S:
                end()
            elif now_s - shown_s > _PERIOD_S:
                text = text_of(message)
                if text is not None:
                    shown_s = now_s
                    show(text)

        end = self._page.stage.subscribe(topic, kind, take, qos_profile_sensor_data)

    def _show_joint(self, window: Any, show: Callable[[str], object], joint: str) -> None:
        """Show the position, velocity and effort of a joint in the window of a link."""

        def text_of(state: Any) -> str | None:
            if joint not in state.name:
                return None
            number = list(state.name).index(joint)
            rows = {
                "position": state.position,
                "velocity": state.velocity,
                "effort": state.effort,
            }
            return "now " + ", ".join(
                # Noise is no motion.
                f"{name} {values[number] if abs(values[number]) > _NOISE else 0.0:.4g}"
                for name, values in rows.items()
                if len(values) > number and math.isfinite(values[number])
            )

        self._while_open(window, STATES_TOPIC, "sensor_msgs/msg/JointState", text_of, show)

    def _show_contacts(self, window: Any, show: Callable[[str], object], link: str) -> None:
        """Show in the window of a link what it touches, and with which force."""
        topics = self._page.node.get_topic_names_and_types()
        topic = next((name for name, types in topics if _CONTACTS in types), None)
        if topic is None:
            return

        def text_of(message: Any) -> str:
            lines = [
                f"touches <b>{escaped_html(other)}</b> with {force:.3g} N"
                for other, force in contact_forces(message, link).items()
            ]
            return "<br>".join(lines) or "touches nothing"

        self._while_open(window, topic, _CONTACTS, text_of, show)

    @staticmethod
    def _show_all(robot: RobotModelDisplay) -> None:
        for link in robot.hidden_links():
            robot.show_link(link, shown=True)

    def _text(self, robot: RobotModelDisplay, link: str) -> str:
        """Return HTML of the link's frame and place, and of the joint that moves it."""
        frame = robot.frame_of(link)
        lines = [f"frame <b>{escaped_html(frame)}</b>"]
        found = self._page.frames.by_name.get(frame)
        if found is not None and found.pose is not None:
            x, y, z = found.pose.translation
            fixed = escaped_html(self._page.frames.fixed)
            lines.append(f"at {x:.3f}, {y:.3f}, {z:.3f} m in {fixed}")
        description = robot.description
        joint = _joint_above(robot, link)
        if description is None or not joint:
            return "<br>".join(lines)
        model = Joints.for_display(description, lambda _warning: None).get(joint)
        kind = description.joints[joint].type
        lines.append(f"joint <b>{escaped_html(joint)}</b>, {escaped_html(kind)}")
        if model is not None:
            unit = "m" if kind == "prismatic" else "rad"
            limits = model.limits
            if math.isfinite(limits.lower) and math.isfinite(limits.upper):
                lines.append(f"from {limits.lower:.4g} to {limits.upper:.4g} {unit}")
            if math.isfinite(limits.velocity):
                lines.append(f"at most {limits.velocity:.4g} {unit}/s")
            if math.isfinite(limits.effort):
                lines.append(f"at most {limits.effort:.4g} {'N' if unit == 'm' else 'N m'}")
            if model.mimic is not None:
                lines.append(f"follows {escaped_html(model.mimic.joint)}")
        return "<br>".join(lines)


def contact_forces(message: Any, link: str) -> dict[str, float]:
    """Return the magnitude of the force in N between a link and each body that it touches.

    Args:
        message: A ros_gz_interfaces/Contacts.
        link: Name of the link, which is a part of the names of its collisions.
    """
    sums: dict[str, list[float]] = {}
    for contact in message.contacts:
        names = [contact.collision1.name, contact.collision2.name]
        own = [link in _WORDS.split(name) for name in names]
        if not any(own):
            continue
        total = sums.setdefault(names[0 if own[1] else 1], [0.0, 0.0, 0.0])
        for wrench in contact.wrenches:
            force = wrench.body_1_wrench.force
            for axis, part in enumerate((force.x, force.y, force.z)):
                total[axis] += part
    return {other: math.hypot(*total) for other, total in sums.items()}


def _axes_of(frame: str) -> dict[str, Any]:
    return {"Reference Frame": frame, "Length": 0.1, "Radius": 0.005}


def _joint_above(robot: RobotModelDisplay, link: str) -> str:
    """Return the name of the nearest joint with one axis above a link; empty for none."""
    description = robot.description
    if description is None:
        return ""
    by_child = {joint.child: joint for joint in description.joints.values()}
    joint = by_child.get(link)
    while joint is not None and not joint.is_single_axis:
        joint = by_child.get(joint.parent)
    return joint.name if joint is not None else ""
