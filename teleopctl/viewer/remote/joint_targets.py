"""Finds out, and follows when it changes, whom the joint sliders move."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.robot import Joints, JointSet
from teleopctl.viewer.html import escaped
from teleopctl.viewer.remote.controller_managers import ControllerManagerWatch, controller_managers
from teleopctl.viewer.remote.joint_movers import (
    ControllerMover,
    JointMover,
    NoMover,
    Route,
    StatePublisher,
)

if TYPE_CHECKING:
    from teleopctl.viewer.page.page import Page

SLIDERS_TOPIC = "/joint_state_publisher_gui/joint_states"
"""Where sliders say what a ``joint_state_publisher`` shall publish (its ``source_list``)."""

STATES_TOPIC = "/joint_states"

# Any stands for messages: their classes are made at run time, from definitions.


class JointTargets:
    """Chooses what the joint sliders move, from what runs in the graph.

    - active controllers that take positions;
    - where a controller manager runs without such a controller: nobody;
    - a ``joint_state_publisher`` that listens to `SLIDERS_TOPIC`;
    - everybody who listens to ``/joint_states``, where nobody publishes it: the sliders do;
    - nobody, where others publish it, or have done so and are gone: a robot's picture must not
      move by hand because its driver has died. `take_over` says that it shall.

    Args:
        page: Whose node asks and publishes.
        changed: Called with the new mover.

    Attributes:
        is_measured: Whether others publish ``/joint_states``.
    """

    def __init__(self, page: Page, changed: Callable[[JointMover], object]) -> None:
        self._page = page
        self._node = page.node
        self._changed = changed
        self._joints: JointSet | None = None
        self._limits: Joints | None = None
        self._mover: JointMover | None = None
        self._found: tuple[object, ...] = ()
        self._watches: dict[str, ControllerManagerWatch] = {}
        self._gone: tuple[str, ...] = ()
        self.is_measured = False
        self._is_looking = False

    @property
    def mover(self) -> JointMover | None:
        """What the sliders move now."""
        return self._mover

    @property
    def can_take_over(self) -> bool:
        """Whether the joint states' publishers have gone, so that the sliders may replace them."""
        return isinstance(self._mover, NoMover) and bool(self._gone) and not self._others()

    def begin(self, joints: JointSet, limits: Joints) -> None:
        """Look for movers of these joints."""
        self._joints, self._limits = joints, limits
        self._found = ()
        self.look()

    def listen(self) -> None:
        """Follow the controller managers."""
        self._is_looking = True
        self.look()

    def hush(self) -> None:
        """Stop following the graph; sliders that publish continue."""
        self._is_looking = False
        for watch in self._watches.values():
            watch.close()
        self._watches.clear()

    def look(self) -> None:
        """Choose the mover again; to be called when the graph has changed."""
        if not self._is_looking:
            return
        managers = controller_managers(self._node)
        for name in [name for name in self._watches if name not in managers]:
            self._watches.pop(name).close()
        for name in managers:
            if name not in self._watches:
                # Known before the watch asks: its answer may come at once.
                self._watches[name] = ControllerManagerWatch(
                    self._page, name, self._choose, lambda _reason: None
                )
        self._choose()

    def take_over(self) -> None:
        """Publish the joint states in place of the publishers that have gone."""
        self._gone = ()
        self._choose()

    def close(self) -> None:
        """Stop following, and close the mover."""
        self.hush()
        if self._mover is not None:
            self._mover.close()
            self._mover = None

    def _others(self) -> tuple[str, ...]:
        own = self._node.get_fully_qualified_name()
        publishers = self._node.graph().publishers(self._node.resolve_topic_name(STATES_TOPIC))
        return tuple(sorted({token.full_name for token in publishers} - {own}))

    def _choose(self) -> None:
        if self._joints is None or self._limits is None:
            return
        others = self._others()
        self.is_measured = bool(others)
        self._gone = others or self._gone
        routes = [route for watch in self._watches.values() for route in self._routes_of(watch)]
        listens = bool(self._node.count_subscribers(SLIDERS_TOPIC))
        # What decides in this case: anything else may change while joints are on their way.
        managers = tuple(self._watches)
        found: tuple[object, ...]
        if routes:
            found = ("controllers", *routes)
        elif managers:
            found = ("managers", *managers)
        elif listens:
            found = ("listener",)
        else:
            found = ("publishers", others, self._gone)
        if found == self._found and self._mover is not None:
            return
        self._found = found
        if self._mover is not None:
            self._mover.close()
        self._mover = self._make(routes, others, listens=listens)
        self._changed(self._mover)

    def _routes_of(self, watch: ControllerManagerWatch) -> list[Route]:
        namespace = watch.name.rpartition("/")[0]
        routes = (_route(f"{namespace}/{one.name}", one) for one in watch.controllers)
        return [
            route
            for route in routes
            if route is not None and any(name in (self._limits or ()) for name in route.joints)
        ]

    def _make(self, routes: list[Route], others: tuple[str, ...], *, listens: bool) -> JointMover:
        assert self._joints is not None
        assert self._limits is not None
        if routes:
            return ControllerMover(self._node, routes, self._limits)
        if self._watches:
            return NoMover(
                f"No active controller of {_names(self._watches)} takes positions: "
                "activate one in the tab <b>Controllers</b>."
            )
        if listens:
            return StatePublisher(
                self._node, SLIDERS_TOPIC, "The sliders put the joints.", self._joints,
                repeats=False,
            )  # fmt: skip
        if others:
            return NoMover(
                f"{STATES_TOPIC} comes from {_names(others)}, which takes no orders from here."
            )
        if self._gone:
            return NoMover(f"{_names(self._gone)}, where {STATES_TOPIC} came from, is gone.")
        return StatePublisher(
            self._node,
            STATES_TOPIC,
            f"The sliders put the joints: nobody else publishes {STATES_TOPIC}.",
            self._joints,
            repeats=True,
        )


def _route(name: str, controller: Any) -> Route | None:
    """The way to a controller, from its controller_manager_msgs/ControllerState; None for others.

    The interfaces that a controller commands are called JOINT/INTERFACE, below a chained
    controller CONTROLLER/JOINT/INTERFACE.
    """
    interfaces = list(controller.required_command_interfaces)
    takes_trajectories = controller.type.endswith("/JointTrajectoryController")
    takes_positions = controller.type.endswith(
        ("/ForwardCommandController", "/JointGroupPositionController")
    ) and all(interface.endswith("/position") for interface in interfaces)
    if controller.state != "active" or not (takes_trajectories or takes_positions):
        return None
    chained = [one for one in controller.chain_connections if one.reference_interfaces]
    joints = []
    for interface in interfaces:
        joint = interface.rpartition("/")[0]
        for connection in chained:
            joint = joint.removeprefix(f"{connection.name}/")
        joints.append(joint)
    return Route(name, tuple(dict.fromkeys(joints)), takes_trajectories) if joints else None


def _names(names: Any) -> str:
    return ", ".join(f"<b>{escaped(name)}</b>" for name in names)
