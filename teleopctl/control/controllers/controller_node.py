"""A controller's node as one instance of the controller uses it.

When a controller's code is reloaded, the new instance is configured while the old one runs, on the
same node. What the new instance creates in the same way as the old one (a publisher, subscription,
service, client or action server of the same name, type and options) is the old one's entity, whose
callbacks change hands between two control cycles. So the graph does not change, no message is lost,
and an action's goals stay active. What is created otherwise exists beside the old entity until the
exchange.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, cast

from teleopctl.control.controllers.base import ControllerInterfaceParams
from teleopctl.node import Parameter

if TYPE_CHECKING:
    from teleopctl.node import Node

# Any, in this module: entities, messages and options of any type, as the node's methods take them.

_PUBLISHER, _SUBSCRIPTION, _SERVICE, _CLIENT = "publisher", "subscription", "service", "client"
_TIMER, _ACTION_SERVER = "timer", "action server"


@dataclass(eq=False)
class _Entity:
    """Entity of a node.

    Attributes:
        kind: Kind of the entity.
        key: Type, name and options; None for an entity that is never shared.
        entity: The entity itself.
        callbacks: Callbacks of the instance that created or shares the entity.
    """

    kind: str
    key: object
    entity: Any
    callbacks: tuple[Callable[..., Any], ...] = ()

    def connect(self) -> None:
        """Make the entity call these callbacks."""
        if self.kind == _ACTION_SERVER:
            goal, accepted, cancel = self.callbacks
            self.entity.register_goal_callback(goal)
            self.entity.register_handle_accepted_callback(accepted)
            self.entity.register_cancel_callback(cancel)
        elif self.callbacks:
            (self.entity.callback,) = self.callbacks


class ControllerNode:
    """View of a controller's node for one instance of the controller, with the node's attributes.

    Args:
        node: Node of the controller.
        make_action_server: Function that creates an action server on the node.
        earlier: View of the instance that this one will replace; None for the first instance.

    Attributes:
        defaults: Parameters that this instance has declared, with their defaults.
    """

    def __init__(
        self,
        node: Node,
        make_action_server: Callable[..., Any],
        earlier: ControllerNode | None = None,
    ) -> None:
        self._node = node
        self._make_action_server = make_action_server
        self._earlier = earlier
        self._entities: list[_Entity] = []
        # Entities that belong to another instance: the earlier one, or the one that took over.
        self._of_others: list[Any] = []
        self._parameter_callbacks: list[tuple[str, Any]] = []
        self.defaults: dict[str, Any] = {}
        self._changed_defaults: dict[str, Parameter] = {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self._node, name)

    def successor(self) -> ControllerNode:
        """Return a view for the instance that is to replace this one."""
        return ControllerNode(self._node, self._make_action_server, self)

    # -- creation of entities ----------------------------------------------------------------------

    def create_publisher(self, msg_type: Any, topic: str, qos_profile: Any, **options: Any) -> Any:
        """Create a publisher, or share that of the earlier instance."""
        return self._create(
            _PUBLISHER,
            (msg_type, topic, qos_profile, options),
            (),
            lambda: self._node.create_publisher(msg_type, topic, qos_profile, **options),
        )

    def create_subscription(
        self,
        msg_type: Any,
        topic: str,
        callback: Callable[..., Any],
        qos_profile: Any,
        **options: Any,
    ) -> Any:
        """Create a subscription, or share that of the earlier instance."""
        return self._create(
            _SUBSCRIPTION,
            (msg_type, topic, qos_profile, options),
            (callback,),
            lambda: self._node.create_subscription(
                msg_type, topic, callback, qos_profile, **options
            ),
        )

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Callable[..., Any], **options: Any
    ) -> Any:
        """Create a service server, or share that of the earlier instance."""
        return self._create(
            _SERVICE,
            (srv_type, srv_name, options),
            (callback,),
            lambda: self._node.create_service(srv_type, srv_name, callback, **options),
        )

    def create_client(self, srv_type: Any, srv_name: str, **options: Any) -> Any:
        """Create a service client, or share that of the earlier instance."""
        return self._create(
            _CLIENT,
            (srv_type, srv_name, options),
            (),
            lambda: self._node.create_client(srv_type, srv_name, **options),
        )

    def create_timer(self, *arguments: Any, **options: Any) -> Any:
        """Create a timer, which ends with this instance."""
        return self._create(
            _TIMER, None, (), lambda: self._node.create_timer(*arguments, **options)
        )

    # Called by action servers and clients that a controller creates by their classes.
    def add_endpoint(self, endpoint: Any) -> Any:
        """Register an endpoint, which is destroyed with this instance; return it."""
        self._node.add_endpoint(endpoint)
        self._entities.append(_Entity(_SERVICE, None, endpoint))
        return endpoint

    # Without the node, for `ControllerInterfaceParams.action_server`: it is always this one.
    def create_action_server(
        self,
        _node: object,
        action_type: Any,
        name: str,
        *,
        goal_callback: Callable[..., Any],
        handle_accepted_callback: Callable[..., Any],
        cancel_callback: Callable[..., Any],
        **options: Any,
    ) -> Any:
        """Create an action server, or share that of the earlier instance with its goals."""
        server = self._create(
            _ACTION_SERVER,
            (action_type, name, options),
            (goal_callback, handle_accepted_callback, cancel_callback),
            lambda: self._make_action_server(
                self._node,
                action_type,
                name,
                goal_callback=goal_callback,
                handle_accepted_callback=handle_accepted_callback,
                cancel_callback=cancel_callback,
                **options,
            ),
        )
        return _SharedActionServer(server, self._destroy)

    def _create(
        self,
        kind: str,
        key: object,
        callbacks: tuple[Callable[..., Any], ...],
        make: Callable[[], Any],
    ) -> Any:
        shared = None if self._earlier is None or key is None else self._earlier.find(kind, key)
        if shared is not None and not any(one.entity is shared for one in self._entities):
            self._of_others.append(shared)
            entity = shared
        else:
            entity = make()
        self._entities.append(_Entity(kind, key, entity, callbacks))
        return entity

    def find(self, kind: str, key: object) -> Any:
        """Return the entity that this instance created with a type, name and options, or None."""
        for one in self._entities:
            if one.kind == kind and one.key == key:
                return one.entity
        return None

    def active_goals(self) -> list[tuple[Callable[[Any], Any], Any]]:
        """Return the active goals of shared action servers, with this instance's callback each.

        The callback is that for accepted goals.
        """
        return [
            (one.callbacks[1], goal)
            for one in self._entities
            if one.kind == _ACTION_SERVER and one.entity in self._of_others
            for goal in one.entity.active_goals()
        ]

    # -- destruction of entities -------------------------------------------------------------------

    def destroy_publisher(self, publisher: Any) -> bool:
        """Destroy a publisher, unless another instance uses it."""
        return self._destroy(publisher, _PUBLISHER)

    def destroy_subscription(self, subscription: Any) -> bool:
        """Destroy a subscription, unless another instance uses it."""
        return self._destroy(subscription, _SUBSCRIPTION)

    def destroy_service(self, service: Any) -> bool:
        """Destroy a service server, unless another instance uses it."""
        return self._destroy(service, _SERVICE)

    def destroy_client(self, client: Any) -> bool:
        """Destroy a service client, unless another instance uses it."""
        return self._destroy(client, _CLIENT)

    def destroy_timer(self, timer: Any) -> bool:
        """Destroy a timer."""
        return self._destroy(timer, _TIMER)

    def _destroy(self, entity: Any, kind: str = _ACTION_SERVER) -> bool:
        self._entities = [one for one in self._entities if one.entity is not entity]
        if any(other is entity for other in self._of_others):
            return True
        if kind == _ACTION_SERVER:
            entity.destroy()
            return True
        return bool(getattr(self._node, f"destroy_{kind}")(entity))

    # -- parameters --------------------------------------------------------------------------------

    # A parameter that the earlier instance declared can be declared again. If it still
    # has the earlier default, the new one applies.

    def has_parameter(self, name: str) -> bool:
        """Return whether a parameter is declared, other than by the earlier instance alone."""
        earlier = self._earlier
        if earlier is not None and name in earlier.defaults and name not in self.defaults:
            return False
        return self._node.has_parameter(name)

    def declare_parameter(
        self, name: str, value: Any = None, *arguments: Any, **options: Any
    ) -> Parameter:
        """Declare a parameter; one of the earlier instance keeps a value that was set."""
        earlier = self._earlier
        if earlier is None or name not in earlier.defaults or name in self.defaults:
            parameter = self._node.declare_parameter(name, value, *arguments, **options)
            self.defaults[name] = value
            return parameter
        self.defaults[name] = value
        if (
            value is not None
            and not _same(value, earlier.defaults[name])
            and _same(self._node.get_parameter(name).value, earlier.defaults[name])
            and name not in self._node.get_parameter_overrides()
        ):
            self._changed_defaults[name] = Parameter(name, value=value)
        return self.get_parameter(name)

    def declare_parameters(
        self, namespace: str, parameters: Iterable[tuple[Any, ...]], *arguments: Any
    ) -> list[Parameter]:
        """Declare parameters below a prefix, each ``(name[, value[, descriptor]])``."""
        prefix = f"{namespace}." if namespace else ""
        return [
            self.declare_parameter(prefix + name, *(*rest, None, None)[:2], *arguments)
            for name, *rest in parameters
        ]

    def undeclare_parameter(self, name: str) -> None:
        """Undeclare a parameter."""
        self._node.undeclare_parameter(name)
        self.defaults.pop(name, None)
        self._changed_defaults.pop(name, None)

    def get_parameter(self, name: str) -> Parameter:
        """Return a parameter; that with this instance's default before it has taken over."""
        return self._changed_defaults.get(name) or self._node.get_parameter(name)

    def get_parameters(self, names: Iterable[str]) -> list[Parameter]:
        """Return several parameters by name."""
        return [self.get_parameter(name) for name in names]

    def get_parameter_or(self, name: str, alternative_value: Any = None) -> Parameter:
        """Return a parameter; the alternative if it has no value."""
        return self._changed_defaults.get(name) or self._node.get_parameter_or(
            name, alternative_value
        )

    def add_pre_set_parameters_callback(self, callback: Any) -> None:
        """Register a callback until this instance ends."""
        self._add_parameter_callback("pre", callback)

    def add_on_set_parameters_callback(self, callback: Any) -> None:
        """Register a callback until this instance ends."""
        self._add_parameter_callback("on", callback)

    def add_post_set_parameters_callback(self, callback: Any) -> None:
        """Register a callback until this instance ends."""
        self._add_parameter_callback("post", callback)

    def _add_parameter_callback(self, when: str, callback: Any) -> None:
        getattr(self._node, f"add_{when}_set_parameters_callback")(callback)
        self._parameter_callbacks.append((when, callback))

    # -- exchange of two instances -----------------------------------------------------------------

    def connect_callbacks(self) -> None:
        """Make all entities call this instance's callbacks."""
        for one in self._entities:
            one.connect()

    def give_away(self, successor: ControllerNode) -> None:
        """Leave the shared entities to the instance that has taken over, and apply its parameters.

        What this instance destroys from now on is destroyed only if it is not shared.
        """
        self._remove_parameter_callbacks()
        self._of_others, successor._of_others = successor._of_others, []
        successor._earlier = None
        for name in self.defaults.keys() - successor.defaults.keys():
            with contextlib.suppress(Exception):  # read-only, or undeclared by its own code
                self._node.undeclare_parameter(name)
        for name, parameter in list(successor._changed_defaults.items()):
            results = None
            with contextlib.suppress(Exception):  # a callback of its own code
                results = self._node.set_parameters([parameter])
            # A refused value, of a read-only parameter, stays what this instance reads.
            if results and results[0].successful:
                del successor._changed_defaults[name]

    def close(self) -> None:
        """Destroy the entities that are this instance's alone, and remove its callbacks."""
        self._remove_parameter_callbacks()
        for one in reversed(self._entities):
            self._destroy(one.entity, one.kind)
        if self._earlier is not None:
            for name in self.defaults:
                if name not in self._earlier.defaults:
                    with contextlib.suppress(Exception):  # as above
                        self._node.undeclare_parameter(name)

    def _remove_parameter_callbacks(self) -> None:
        callbacks, self._parameter_callbacks = self._parameter_callbacks, []
        for when, callback in callbacks:
            with contextlib.suppress(ValueError):
                getattr(self._node, f"remove_{when}_set_parameters_callback")(callback)


def with_controller_node(params: ControllerInterfaceParams) -> ControllerInterfaceParams:
    """Return a first instance's arguments with a `ControllerNode` as the node."""
    return _with(params, ControllerNode(params.node, params.action_server))


def for_successor(
    params: ControllerInterfaceParams,
) -> tuple[ControllerNode, ControllerNode, ControllerInterfaceParams]:
    """Return the view of an instance, that of its successor, and the successor's arguments."""
    earlier = cast("ControllerNode", params.node)
    view = earlier.successor()
    return earlier, view, _with(params, view)


def _with(params: ControllerInterfaceParams, view: ControllerNode) -> ControllerInterfaceParams:
    return replace(params, node=cast("Node", view), action_server=view.create_action_server)


class _SharedActionServer:
    """Action server as one instance of a controller uses it, with the server's attributes.

    Args:
        server: The action server.
        destroy: Function that destroys it, unless another instance uses it.
    """

    def __init__(self, server: Any, destroy: Callable[[Any], object]) -> None:
        self._server = server
        self._destroy = destroy

    def __getattr__(self, name: str) -> Any:
        return getattr(self._server, name)

    def destroy(self) -> None:
        """Destroy the server, unless another instance of the controller uses it."""
        self._destroy(self._server)


def _same(one: object, other: object) -> bool:
    """Return whether two values of a parameter are equal, as lists or arrays, too."""
    if isinstance(one, str | bytes) or not isinstance(one, Iterable):
        return type(one) is type(other) and one == other
    return isinstance(other, Iterable) and list(one) == list(other)
