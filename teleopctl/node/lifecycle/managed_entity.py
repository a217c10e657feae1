"""Managed entities of lifecycle nodes, lifecycle publishers among them."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, Concatenate, ParamSpec, TypeVar, overload

from teleopctl.interfaces import MessageT
from teleopctl.node.endpoints.publisher import Publisher
from teleopctl.node.lifecycle.states import LifecycleState, TransitionCallbackReturn
from teleopctl.node.node_core import NodeCore
from teleopctl.node.values.qos import QoSProfile

# ruff: noqa: ARG002 -- overrides use the previous state


_P = ParamSpec("_P")
_ResultT = TypeVar("_ResultT")
_EntityT = TypeVar("_EntityT", bound="SimpleManagedEntity")


class ManagedEntity:
    """Base of entities that receive the transition callbacks of a lifecycle node.

    All callbacks succeed unless they are overridden.
    """

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle the configure transition (acquire resources); the base returns SUCCESS."""
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle the cleanup transition (release the resources); the base returns SUCCESS."""
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle the shutdown transition from any primary state; the base returns SUCCESS."""
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle the activate transition (start working); the base returns SUCCESS."""
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle the deactivate transition (stop working); the base returns SUCCESS."""
        return TransitionCallbackReturn.SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle another callback's error; the base returns SUCCESS, leading to unconfigured."""
        return TransitionCallbackReturn.SUCCESS


class SimpleManagedEntity(ManagedEntity):
    """Managed entity that only records whether it is activated."""

    def __init__(self) -> None:
        self._enabled = False

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Mark the entity as activated, and return SUCCESS."""
        self._enabled = True
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Mark the entity as deactivated, and return SUCCESS."""
        self._enabled = False
        return TransitionCallbackReturn.SUCCESS

    @property
    def is_activated(self) -> bool:
        """Whether the entity is activated."""
        return self._enabled

    @overload
    @staticmethod
    def when_enabled(
        wrapped: Callable[Concatenate[_EntityT, _P], _ResultT],
        *,
        when_not_enabled: Callable[[], object] | None = None,
    ) -> Callable[Concatenate[_EntityT, _P], _ResultT | None]: ...

    @overload
    @staticmethod
    def when_enabled(
        wrapped: None = None, *, when_not_enabled: Callable[[], object] | None = None
    ) -> Callable[
        [Callable[Concatenate[_EntityT, _P], _ResultT]],
        Callable[Concatenate[_EntityT, _P], _ResultT | None],
    ]: ...

    # Any: see the overloads above.
    @staticmethod
    def when_enabled(
        wrapped: Any = None, *, when_not_enabled: Callable[[], object] | None = None
    ) -> Any:
        """Decorate a method so that it only runs while the entity is activated.

        Args:
            wrapped: Method to decorate; if None, a decorator is returned.
            when_not_enabled: Called instead of the method while the entity is not activated.
        """
        if wrapped is None:
            return functools.partial(
                SimpleManagedEntity.when_enabled, when_not_enabled=when_not_enabled
            )

        @functools.wraps(wrapped)
        def only_when_enabled(self: SimpleManagedEntity, *args: Any, **kwargs: Any) -> Any:
            if self._enabled:
                return wrapped(self, *args, **kwargs)
            if when_not_enabled is not None:
                when_not_enabled()
            return None

        return only_when_enabled


class LifecyclePublisher(SimpleManagedEntity, Publisher[MessageT]):
    """Publisher that drops messages unless activated; made by ``create_lifecycle_publisher``.

    The publisher is in the graph from its creation on.
    """

    def __init__(
        self, node: NodeCore, msg_type: type[MessageT], topic: str, qos: QoSProfile
    ) -> None:
        SimpleManagedEntity.__init__(self)
        Publisher.__init__(self, node, msg_type, topic, qos)

    def publish(self, msg: MessageT | bytes | bytearray) -> None:
        """Publish a message; drop it unless the publisher is activated; see `Publisher.publish`."""
        if self.is_activated:
            Publisher.publish(self, msg)
