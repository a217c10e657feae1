"""``launch.action``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from teleopctl import launch as model
from teleopctl.errors import TeleopctlError

from .condition import Condition
from .launch_description_entity import LaunchDescriptionEntity

if TYPE_CHECKING:
    from .launch_context import LaunchContext


class Action(LaunchDescriptionEntity):
    """Base class of launch actions.

    A subclass overrides `execute`; ROS 2's own actions override `model_action` instead.

    Args:
        condition: The action is executed only if it holds.
    """

    def __init__(self, *, condition: Condition | None = None) -> None:
        super().__init__()
        self._condition = condition

    # Any: the entity and the parser of a text front end; constructor arguments differ by class.
    @classmethod
    def parse(cls, entity: Any, parser: Any) -> tuple[type[Action], dict[str, Any]]:
        """Return the class and its constructor arguments; a subclass adds its own."""
        return cls, parser.words_of(cls, entity)

    @property
    def condition(self) -> Condition | None:
        """Condition under which the action is executed, or None."""
        return self._condition

    def describe(self) -> str:
        """Return a readable form of the action."""
        return repr(self)

    def describe_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return the entities that the action contains and that are always visited."""
        return self.get_sub_entities() if self._condition is None else []

    def describe_conditional_sub_entities(
        self,
    ) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        """Return the entities visited under a condition, with the condition's description."""
        if self._condition is None:
            return []
        return [(f"Conditionally included by {self.describe()}", self.get_sub_entities())]

    def visit(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:
        """Execute the action if its condition holds; return the entities to visit next."""
        if self._condition is not None and not self._condition.evaluate(context):
            return None
        try:
            return self.execute(context)
        finally:
            self.done(context)

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:
        """Execute the action; return the entities to visit next."""
        from .launch_context import LaunchContext

        try:
            with LaunchContext.standing_for(context) as known, known.launch.user_code():
                known.launch.run_action(self.model_action())
        except TeleopctlError as error:
            cause = error.__cause__
            if cause is None or isinstance(cause, TeleopctlError):
                # The exception that ROS 2's launch raises, which programs catch.
                raise RuntimeError(error.message) from error
        else:
            return None
        # Not from the error that it caused: the causes would run in a circle.
        raise cause

    def done(self, context: LaunchContext) -> None:
        """Emit `ExecutionComplete`, once the action's future is done if it has one."""
        future = self.get_asyncio_future()
        if future is None:
            self.tell_completion(context)
            return
        from ._asyncio import when_done

        when_done(future, lambda _: self.tell_completion(context))
        context.add_completion_future(future)

    def tell_completion(self, context: LaunchContext) -> None:
        """Emit `ExecutionComplete` if an event handler matches it."""
        from .events.execution_complete import ExecutionComplete

        event = ExecutionComplete(action=self)
        if context.would_handle_event(event):
            context.emit_event_sync(event)

    def model_action(self) -> model.Action:
        """Return the corresponding action of `teleopctl.launch`; by default one without effect."""
        return _NOTHING


_NOTHING = model.IncludeSteps(steps=(), arguments=())
