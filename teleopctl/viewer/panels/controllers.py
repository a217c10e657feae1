"""Panel of a controller manager: states of controllers and hardware, and buttons to change them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

from teleopctl.interfaces import from_seconds, get_message, set_stamp
from teleopctl.viewer.html import escaped_html, note_html
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.panels.controller_managers import (
    ControllerManagerWatch,
    ManagerErrors,
    controller_managers,
)
from teleopctl.viewer.service_calls import ServiceCalls

if TYPE_CHECKING:
    from teleopctl.node import Node

# Actions for a controller or a component by its state; the usual one first.
_CONTROLLER_ACTIONS = {
    "active": ("Deactivate",),
    "inactive": ("Activate", "Clean up", "Unload"),
    "unconfigured": ("Activate", "Configure", "Unload"),
    "finalized": ("Unload",),
}
_COMPONENT_ACTIONS = {
    "active": ("Deactivate",),
    "inactive": ("Activate", "Clean up"),
    "unconfigured": ("Activate", "Configure"),
}
# Target lifecycle_msgs/State of each action: ID and label.
_COMPONENT_TARGETS = {
    "Activate": (3, "active"),
    "Deactivate": (2, "inactive"),
    "Configure": (2, "inactive"),
    "Clean up": (1, "unconfigured"),
}
_SERVICES = {
    "Configure": ("configure_controller", "ConfigureController"),
    "Clean up": ("cleanup_controller", "CleanupController"),
    "Unload": ("unload_controller", "UnloadController"),
    "Load": ("load_controller", "LoadController"),
}
# Green, amber, grey, red.
_LAMPS = {"active": "#2f9e44", "inactive": "#e0a100", "unconfigured": "#8a8f98"}
_OTHER_LAMP = "#e5484d"
_MOST_INTERFACES = 12
_STRICT = 2
# Timeout of a switch in the manager, and of service calls, which respond a little later.
_SWITCH_TIMEOUT_S = 5.0
_TIMEOUT_S = 15.0
_NOBODY = (
    "No controller manager is running. Start one with <code>teleopctl launch sim.yaml</code>, or "
    "for a real robot with <code>teleopctl launch controller.yaml</code>."
)

# Any: messages, whose classes are created from definitions at run time.


class ControllersPanel(Panel):
    """Panel of controllers and hardware components, with buttons to change their states."""

    title: ClassVar[str] = "Controllers"
    icon = "engine"

    @classmethod
    def is_needed(cls, node: Node) -> bool:
        """Return whether a controller manager runs."""
        return bool(controller_managers(node))

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._calls = ServiceCalls(page)
        self._errors = ManagerErrors(page)
        self._watch: ControllerManagerWatch | None = None
        self._controllers: dict[str, _Row] = {}
        self._components: dict[str, _Row] = {}
        self._is_watched = False

    def build(self) -> None:
        """Add the choice of a controller manager, and folders for controllers and hardware."""
        self._note = self.gui.add_html(note_html(_NOBODY))
        self._choice: Any = self.gui.add_dropdown("Manager", ("",), visible=False)
        self._choice.on_update(self.page.on_node_thread(lambda _event: self._offer_managers()))
        self._place = self.gui.add_folder(None)
        self._load = self.gui.add_folder("Load", expand_by_default=False, visible=False)
        with self._load:
            self._name: Any = self.gui.add_dropdown("Controller", ("",))
            self.gui.add_button("Load").on_click(
                self.page.on_node_thread(lambda _event: self._load_chosen())
            )
        self._space = self.gui.add_html('<div style="height:.75em"></div>', visible=False)
        self._hardware = self.gui.add_folder("Hardware", visible=False)

    def began(self) -> None:
        """Subscribe to ``/rosout`` and to the chosen controller manager."""
        self._is_watched = True
        self._errors.begin()
        self._offer_managers()

    def ended(self) -> None:
        """Unsubscribe from ``/rosout`` and the controller manager; drop pending calls."""
        self._is_watched = False
        self._follow("")
        self._errors.end()
        self._calls.close()

    def close(self) -> None:
        """Unsubscribe from everything; called when the viewer is destroyed."""
        self.ended()

    def graph_changed(self) -> None:
        """Update the offered controller managers after a change of the ROS graph."""
        if self._is_watched:
            self._offer_managers()

    def tick(self) -> None:
        """Report failed calls whose cause was not logged within half a second."""
        self._errors.tick()

    def _offer_managers(self) -> None:
        managers = controller_managers(self.page.node)
        options = tuple(managers) or ("",)
        if options != tuple(self._choice.options):
            chosen = self._choice.value
            self._choice.options = options
            if chosen in options:
                self._choice.value = chosen
        self._choice.visible = len(managers) > 1
        self._follow(self._choice.value)

    def _follow(self, manager: str) -> None:
        if manager == (self._watch.name if self._watch else ""):
            return
        if self._watch is not None:
            self._watch.close()
        self._watch = None
        self._show([], [])
        if not manager:
            self._say(_NOBODY)
            return
        self._say(f"Waiting for {escaped_html(manager)}…")
        self._watch = ControllerManagerWatch(
            self.page,
            manager,
            self._take,
            lambda reason: self._say(escaped_html(reason)),
            with_hardware=True,
        )

    def _say(self, text: str) -> None:
        self._note.content = note_html(text)
        self._note.visible = bool(text)

    # --- showing ------------------------------------------------------------------------------

    def _take(self) -> None:
        assert self._watch is not None
        self._show(self._watch.controllers, self._watch.components)
        self._say("" if self._watch.controllers else "No controller is loaded.")
        self._offer()

    def _show(self, controllers: list[Any], components: list[Any]) -> None:
        self._fill(self._place, self._controllers, {one.name: one for one in controllers})
        self._fill(self._hardware, self._components, {one.name: one for one in components})
        self._hardware.visible = self._space.visible = bool(components)
        self._load.visible = self._watch is not None

    def _fill(self, place: Any, rows: dict[str, _Row], found: dict[str, Any]) -> None:
        for name in [name for name in rows if name not in found]:
            rows.pop(name).remove()
        is_hardware = rows is self._components
        for name, one in found.items():
            if name not in rows:
                act = self._act_on_component if is_hardware else self._act
                with place:
                    rows[name] = _Row(self.page, name, act)
            if is_hardware:
                rows[name].show(
                    one.state.label, one.plugin_name, [], _COMPONENT_ACTIONS.get(one.state.label)
                )
            else:
                interfaces = one.claimed_interfaces or one.required_command_interfaces
                rows[name].show(one.state, one.type, interfaces, _CONTROLLER_ACTIONS.get(one.state))

    def _offer(self) -> None:
        """Offer the controllers that the manager's parameters have and that are not loaded."""
        assert self._watch is not None
        manager = self._watch.name

        def take(response: Any) -> None:
            if self._watch is None or self._watch.name != manager:
                return
            loaded = {one.name for one in self._watch.controllers}
            names = [
                name.removesuffix(".type")
                for name in response.result.names
                if name.endswith(".type") and name.removesuffix(".type") not in loaded
            ]
            options = tuple(sorted(names)) or ("",)
            if options != tuple(self._name.options):
                self._name.options = options
            self._load.visible = bool(names)

        self._calls.call(
            f"{manager}/list_parameters",
            "rcl_interfaces/srv/ListParameters",
            take,
            lambda _reason: None,
        )

    # --- switching ----------------------------------------------------------------------------

    def _act(self, name: str, action: str) -> None:
        row = self._controllers[name]
        row.is_busy = True
        if action == "Deactivate":
            self._switch(name, deactivate=[name])
        elif action == "Activate" and row.state == "unconfigured":
            self._call("Configure", name, lambda: self._switch(name, activate=[name]))
        elif action == "Activate":
            self._switch(name, activate=[name])
        else:
            self._call(action, name, lambda: self._finish(name))

    def _load_chosen(self) -> None:
        if self._watch is not None and self._name.value:
            self._call("Load", self._name.value, self._watch.refresh)

    def _call(self, action: str, name: str, then: Callable[[], object]) -> None:
        """Call a service that responds with ``ok`` alone; the log has the cause of a failure."""
        if self._watch is None:
            return
        service, type_name = _SERVICES[action]
        since = self._errors.mark()

        def take(response: Any) -> None:
            if response.ok:
                then()
            else:
                self._fail(action, name, since)

        self._calls.call(
            f"{self._watch.name}/{service}",
            f"controller_manager_msgs/srv/{type_name}",
            take,
            lambda reason: self._report_failure(action, name, reason),
            timeout_s=_TIMEOUT_S,
            name=name,
        )

    def _switch(
        self, name: str, activate: list[str] | None = None, deactivate: list[str] | None = None
    ) -> None:
        if self._watch is None:
            return
        action = "Activate" if activate else "Deactivate"
        since = self._errors.mark()
        timeout = get_message("builtin_interfaces/msg/Duration")()
        set_stamp(timeout, from_seconds(_SWITCH_TIMEOUT_S))

        def take(response: Any) -> None:
            if response.ok:
                self._finish(name)
            # Managers before ROS 2 Jazzy return no reason.
            elif getattr(response, "message", ""):
                self._report_failure(action, name, response.message)
            else:
                self._fail(action, name, since)

        self._calls.call(
            f"{self._watch.name}/switch_controller",
            "controller_manager_msgs/srv/SwitchController",
            take,
            lambda reason: self._report_failure(action, name, reason),
            timeout_s=_TIMEOUT_S,
            activate_controllers=activate or [],
            deactivate_controllers=deactivate or [],
            strictness=_STRICT,
            activate_asap=True,
            timeout=timeout,
        )

    def _act_on_component(self, name: str, action: str) -> None:
        if self._watch is None:
            return
        self._components[name].is_busy = True
        number, label = _COMPONENT_TARGETS[action]
        since = self._errors.mark()

        def take(response: Any) -> None:
            if response.ok:
                self._finish(name)
            else:
                self._fail(action, name, since)

        self._calls.call(
            f"{self._watch.name}/set_hardware_component_state",
            "controller_manager_msgs/srv/SetHardwareComponentState",
            take,
            lambda reason: self._report_failure(action, name, reason),
            timeout_s=_TIMEOUT_S,
            name=name,
            target_state=get_message("lifecycle_msgs/msg/State")(id=number, label=label),
        )

    def _fail(self, action: str, name: str, since: int) -> None:
        """Report a failed call with its cause from the log."""
        assert self._watch is not None
        manager = self._watch.name
        self._errors.find_cause(
            (manager, f"{manager.rpartition('/')[0]}/{name}"),
            since,
            lambda cause: self._report_failure(
                action, name, cause or f"{manager} refused; see its log."
            ),
        )

    def _report_failure(self, action: str, name: str, reason: str) -> None:
        self.page.notify(f"{action} {name}: failed", reason, wrong=True)
        self._finish(name)

    def _finish(self, name: str) -> None:
        for rows in (self._controllers, self._components):
            if name in rows:
                rows[name].is_busy = False
        if self._watch is not None:
            self._watch.refresh()


class _Row:
    """Folder of one controller or component: state, type, interfaces and buttons.

    Attributes:
        state: Name of the present state.
    """

    def __init__(self, page: Page, name: str, act: Callable[[str, str], object]) -> None:
        self.state = ""
        self._is_busy = self._can_act = False
        self._folder = page.gui.add_folder(name)
        with self._folder:
            self._text = page.gui.add_html("")
            self._buttons: Any = page.gui.add_button_group("Switch", ("…",))
            self._buttons.on_click(page.on_node_thread(lambda event: act(name, event.target.value)))

    def show(
        self, state: str, type_name: str, interfaces: list[str], actions: tuple[str, ...] | None
    ) -> None:
        """Show state, type, interfaces and action buttons of a controller or hardware component.

        Args:
            state: Name of the state.
            type_name: Type of the controller, or plug-in of the component.
            interfaces: Command interfaces that the controller claims, or would claim when active.
            actions: Buttons to show; None in an unknown state.
        """
        self.state = state
        color = _LAMPS.get(state, _OTHER_LAMP)
        # The full type is long: package and class.
        kind = type_name.rpartition("/")[2]
        content = (
            f'<span style="color:{color}">●</span> <b>{escaped_html(state)}</b> '
            f'<span style="opacity:.7" title="{escaped_html(type_name)}">'
            f"{escaped_html(kind)}</span>"
        )
        if interfaces:
            listed = ", ".join(escaped_html(name) for name in interfaces[:_MOST_INTERFACES])
            more = len(interfaces) - _MOST_INTERFACES
            content += (
                f'<div style="opacity:.7;font-size:12px;overflow-wrap:anywhere">{listed}'
                f"{f' and {more} more' if more > 0 else ''}</div>"
            )
        self._text.content = note_html(content)
        self._can_act = bool(actions)
        self._buttons.visible = self._can_act and not self._is_busy
        if actions:
            self._buttons.options = actions

    @property
    def is_busy(self) -> bool:
        """Whether a service call for the row is pending; the buttons are hidden meanwhile."""
        return self._is_busy

    @is_busy.setter
    def is_busy(self, busy: bool) -> None:
        self._is_busy = busy
        self._buttons.visible = self._can_act and not busy

    def remove(self) -> None:
        """Remove the row's folder from the page."""
        self._folder.remove()
