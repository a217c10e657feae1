"""Conversion of the entities of Python launch files to steps of `teleopctl.launch`."""

from __future__ import annotations

from collections.abc import Iterable

from teleopctl import launch as model
from teleopctl.launch import Condition as ModelCondition, Template, dataclass

from ._places import blamed, here
from .action import Action
from .condition import Condition
from .launch_context import LaunchContext
from .launch_description_entity import LaunchDescriptionEntity


# object: callers may pass anything, which is checked.
def steps(entities: object) -> tuple[model.Step, ...]:
    """Return one entity, several or None as steps of `teleopctl.launch`.

    Raises:
        TypeError: There is something else among them.
    """
    if entities is None:
        return ()
    if isinstance(entities, LaunchDescriptionEntity):
        return (_step(entities),)
    if isinstance(entities, Iterable) and not isinstance(entities, str):
        return tuple(step for entity in entities for step in steps(entity))
    raise TypeError(f"expected an action, got {type(entities).__name__} {entities!r}")


def _step(entity: LaunchDescriptionEntity) -> model.Step:
    place = _place(entity)
    if not isinstance(entity, Action) or _overrides_execution(type(entity)):
        return model.Step(place, (), _Visited(entity))
    conditions = () if entity.condition is None else (condition_of(entity.condition),)
    try:
        return model.Step(
            place,
            conditions,
            entity.model_action(),
            lambda launch: entity.done(LaunchContext.with_launch(launch)),
        )
    except Exception as error:
        raise blamed(error, entity.describe()) from error


def _place(entity: LaunchDescriptionEntity) -> model.Place:
    # A subclass need not call the constructor of its base.
    return getattr(entity, "defined_at", None) or here()


def _overrides_execution(kind: type[Action]) -> bool:
    """Return whether a class overrides `execute` or `visit` below its `model_action`."""

    def distance(name: str) -> int:
        return next(at for at, base in enumerate(kind.__mro__) if name in vars(base))

    return min(distance("execute"), distance("visit")) < distance("model_action")


@dataclass(frozen=True, slots=True)
class _Visited(model.Action):
    """Action of `teleopctl.launch` that visits a user's entity."""

    entity: LaunchDescriptionEntity

    def evaluate(self, launch: model.Launch) -> None:
        """Visit the entity, and run the entities that it returns."""
        if launch.is_trial:
            return
        try:
            context = LaunchContext.with_launch(launch)
            with context.launch.user_code():
                further = steps(self.entity.visit(context))
        except Exception as error:
            raise blamed(error, repr(self.entity)) from error
        launch.run(further)


def condition_of(condition: Condition) -> ModelCondition:
    """Return a condition as one of `teleopctl.launch`."""
    known = condition.model_condition()
    if known is not None:
        return known
    return ModelCondition(Template((_Predicate(condition),), condition.describe()), True)


@dataclass(frozen=True, slots=True)
class _Predicate:
    """Text that is ``true`` if a condition holds, else ``false``."""

    condition: Condition

    @property
    def source(self) -> str:
        """Readable form of the condition."""
        return self.condition.describe()

    def evaluate(self, context: object) -> str:
        """Evaluate the condition."""
        try:
            return "true" if self.condition.evaluate(LaunchContext.of(context)) else "false"
        except Exception as error:
            raise blamed(error, self.source) from error
