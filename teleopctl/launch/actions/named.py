"""What actions upon something that has a name have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from teleopctl.launch.model.action import Action, Entity
from teleopctl.launch.model.template import Template


@dataclass(frozen=True, slots=True, kw_only=True)
class NameAndValue(Action):
    """Base of actions with a name and a value."""

    keys = ("name", "value")

    name: Template
    value: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read the name and the value."""
        return cls(name=entity.required("name"), value=entity.required("value"))
