"""Lifecycle nodes."""

from __future__ import annotations

from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.interfaces import MessageT
from teleopctl.node.lifecycle.managed_entity import LifecyclePublisher, ManagedEntity
from teleopctl.node.lifecycle.services import LifecycleStateMachine
from teleopctl.node.lifecycle.states import (
    LifecycleState,
    TransitionCallbackReturn,
    TransitionState,
)
from teleopctl.node.node import Node
from teleopctl.node.values.qos import QoSProfile

if TYPE_CHECKING:
    from teleopctl.node.endpoints.events import PublisherEventCallbacks
    from teleopctl.node.endpoints.qos_overrides import QoSOverridingOptions
    from teleopctl.node.values.callback_groups import CallbackGroup

_CALLBACKS = {
    TransitionState.CONFIGURING: "on_configure",
    TransitionState.CLEANINGUP: "on_cleanup",
    TransitionState.SHUTTINGDOWN: "on_shutdown",
    TransitionState.ACTIVATING: "on_activate",
    TransitionState.DEACTIVATING: "on_deactivate",
    TransitionState.ERRORPROCESSING: "on_error",
}


class LifecycleNodeMixin(ManagedEntity):
    """Mix-in that adds the life cycle to a `Node` class.

    The callbacks ``on_…`` call those of the managed entities, in the order in which the entities
    were added, up to the first one that does not succeed. So an override must call ``super()``. A
    callback that raises, or returns anything but a `TransitionCallbackReturn`, is logged and counts
    as ERROR.

    Args:
        enable_communication_interface: Whether to offer the services and the topic of the life
            cycle.
        callback_group: Callback group of the services; the node's default group if None.

    Raises:
        TypeError: ``enable_communication_interface`` is not a bool, or the class is not a `Node`.
    """

    def __init__(
        self,
        *,
        enable_communication_interface: bool = True,
        callback_group: CallbackGroup | None = None,
    ) -> None:
        if not isinstance(enable_communication_interface, bool):
            raise TypeError("enable_communication_interface must be a bool")
        # In order: entities created first are activated first.
        self._managed_entities: dict[ManagedEntity, None] = {}
        self._state_machine = LifecycleStateMachine(
            self._node,
            is_served=enable_communication_interface,
            group=callback_group or self._node.default_callback_group,
            change=self._change_state,
        )

    @property
    def _node(self) -> Node:
        if not isinstance(self, Node):
            raise TypeError(f"{type(self).__name__} has a life cycle, and must be a Node as well")
        return self

    # -- transitions -----------------------------------------------------------------------------

    def trigger_configure(self) -> TransitionCallbackReturn:
        """Run `on_configure`, and on success go from unconfigured to inactive; return its result.

        Raises:
            TransitionNotPossibleError: The node is in another state; so do the next four methods.
        """
        return self._change_state("configure")

    def trigger_cleanup(self) -> TransitionCallbackReturn:
        """Run `on_cleanup`, and on success go from inactive to unconfigured; return its result."""
        return self._change_state("cleanup")

    def trigger_shutdown(self) -> TransitionCallbackReturn:
        """Run `on_shutdown`, and go to finalized unless it returns ERROR; return its result."""
        return self._change_state("shutdown")

    def trigger_activate(self) -> TransitionCallbackReturn:
        """Run `on_activate`, and on success go from inactive to active; return its result."""
        return self._change_state("activate")

    def trigger_deactivate(self) -> TransitionCallbackReturn:
        """Run `on_deactivate`, and on success go from active to inactive; return its result."""
        return self._change_state("deactivate")

    def _change_state(self, transition: int | str) -> TransitionCallbackReturn:
        """Run a transition with its callback; after an error, run error processing too."""
        before = self._state_machine.begin(transition)
        outcome = self._run_callback(before)
        self._state_machine.end(outcome)
        if outcome is TransitionCallbackReturn.ERROR:
            self._state_machine.end(self._run_callback(before))
        return outcome

    def _run_callback(self, before: LifecycleState) -> TransitionCallbackReturn:
        name = _CALLBACKS[TransitionState(self._state_machine.state.state_id)]
        try:
            # Any: overrides may return anything.
            outcome: Any = getattr(self, name)(before)
        except Exception:  # noqa: BLE001 -- counts as an error of the callback
            import traceback

            self._node.get_logger().error(f"{name}() failed:\n{traceback.format_exc()}")
            return TransitionCallbackReturn.ERROR
        if isinstance(outcome, TransitionCallbackReturn):
            return outcome
        self._node.get_logger().error(
            f"{name}() returned {outcome!r}, which is not a TransitionCallbackReturn"
        )
        return TransitionCallbackReturn.ERROR

    # -- callbacks -------------------------------------------------------------------------------

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Call the managed entities' `on_configure` until one fails; return the last result."""
        return self._call_entities("on_configure", state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Call the managed entities' `on_cleanup` until one fails; return the last result."""
        return self._call_entities("on_cleanup", state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Call the managed entities' `on_shutdown` until one fails; return the last result."""
        return self._call_entities("on_shutdown", state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Call the managed entities' `on_activate` until one fails; return the last result."""
        return self._call_entities("on_activate", state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Call the managed entities' `on_deactivate` until one fails; return the last result."""
        return self._call_entities("on_deactivate", state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Call the managed entities' `on_error` until one fails; return the last result."""
        return self._call_entities("on_error", state)

    def _call_entities(self, name: str, state: LifecycleState) -> TransitionCallbackReturn:
        for entity in list(self._managed_entities):
            callback: Callable[[LifecycleState], object] = getattr(entity, name)
            outcome = callback(state)
            if not isinstance(outcome, TransitionCallbackReturn):
                raise TypeError(
                    f"{name}() of {entity!r} returned {outcome!r}, "
                    "which is not a TransitionCallbackReturn"
                )
            if outcome is not TransitionCallbackReturn.SUCCESS:
                return outcome
        return TransitionCallbackReturn.SUCCESS

    # -- entities --------------------------------------------------------------------------------

    def add_managed_entity(self, entity: ManagedEntity) -> None:
        """Add an entity that receives the node's transition callbacks.

        Raises:
            TypeError: ``entity`` is not a `ManagedEntity`.
        """
        if not isinstance(entity, ManagedEntity):
            raise TypeError("Expected a rclpy.lifecycle.ManagedEntity instance.")
        self._managed_entities[entity] = None

    def create_lifecycle_publisher(
        self,
        msg_type: type[MessageT],
        topic: str,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: PublisherEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
    ) -> LifecyclePublisher[MessageT]:
        """Create and return a publisher that sends after an activation, until a deactivation."""
        publisher = Node.create_publisher(
            self._node,
            msg_type,
            topic,
            qos_profile,
            callback_group=callback_group,
            event_callbacks=event_callbacks,
            qos_overriding_options=qos_overriding_options,
            publisher_class=LifecyclePublisher,
        )
        assert isinstance(publisher, LifecyclePublisher)
        # Programs such as ROS 2's demo use destroy_publisher and create publishers repeatedly.
        self._managed_entities = {
            entity: None
            for entity in (*self._managed_entities, publisher)
            if not (isinstance(entity, LifecyclePublisher) and entity.is_destroyed)
        }
        return publisher

    def destroy_lifecycle_publisher(self, publisher: LifecyclePublisher[MessageT]) -> bool:
        """Destroy a lifecycle publisher; return False if it is not this node's."""
        self._managed_entities.pop(publisher, None)
        return Node.destroy_publisher(self._node, publisher)


class LifecycleNode(LifecycleNodeMixin, Node):
    """Node with a managed life cycle, which other programs can configure and activate.

    Args:
        node_name: Name of the node, unless ``__node`` is remapped.
        enable_communication_interface: Whether to offer the services and the topic of the life
            cycle.
        options: Further arguments of `Node`.

    Raises:
        TypeError: ``enable_communication_interface`` is not a bool.

    Example:
        ```python
        class Camera(LifecycleNode):
            def on_configure(self, state):
                self.images = self.create_lifecycle_publisher(Image, "image", 1)
                return super().on_configure(state)
        ```
    """

    # Any: Node checks its arguments.
    def __init__(
        self, node_name: str, *, enable_communication_interface: bool = True, **options: Any
    ) -> None:
        Node.__init__(self, node_name, **options)
        try:
            LifecycleNodeMixin.__init__(
                self, enable_communication_interface=enable_communication_interface
            )
        except BaseException:
            # A node whose constructor failed must not stay in the graph.
            Node.destroy_node(self)
            raise
