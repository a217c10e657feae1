"""Conversion of texts with substitutions to templates of `teleopctl.launch`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from os import PathLike, fspath
from typing import Any

from teleopctl.launch import (
    Call,
    ComputedText,
    LaunchContext as Evaluated,
    Template,
    dataclass,
    literal,
)

from ._places import blamed
from .launch_context import LaunchContext
from .substitution import Substitution


@dataclass(frozen=True, slots=True)
class Performed:
    """Computed text of a substitution that has a ``perform`` of its own."""

    substitution: Substitution

    @property
    def source(self) -> str:
        """Readable form of the substitution."""
        return self.substitution.describe()

    def evaluate(self, context: object) -> str:
        """Perform the substitution."""
        assert isinstance(context, Evaluated)
        try:
            return str(self.substitution.perform(LaunchContext.of(context)))
        except Exception as error:
            raise blamed(error, self.source) from error


# object: callers may pass anything, which is checked.
def template(text: object) -> Template:
    """Return a text, a substitution, or a sequence of them as a template.

    Raises:
        TypeError: The value is none of these.
    """
    if isinstance(text, str):
        return literal(text)
    if isinstance(text, PathLike):
        return literal(fspath(text))
    if isinstance(text, Substitution):
        known = text.template()
        return known if known is not None else Template((Performed(text),), text.describe())
    if isinstance(text, Iterable):
        parts: list[str | Call | ComputedText] = []
        source = ""
        for item in text:
            inner = template(item)
            parts += inner.parts
            source += inner.source
        return Template(tuple(parts), source)
    raise TypeError(
        f"expected a text or a substitution, or a list of them, got {type(text).__name__} {text!r}"
    )


def optional(text: object) -> Template | None:
    """Return a text, number or truth value as a template; None for None."""
    if text is None:
        return None
    if isinstance(text, bool):
        return literal("true" if text else "false")
    return literal(str(text)) if isinstance(text, int | float) else template(text)


# Any: names are whatever text a dictionary can have. object: texts, truth values and numbers.
def pairs(entries: Mapping[Any, object] | None) -> tuple[tuple[Template, Template], ...]:
    """Return names and values as templates; an empty tuple for None."""
    return tuple(
        (template(name), optional(value) or literal("")) for name, value in (entries or {}).items()
    )


# object: texts, truth values and numbers, or None.
def given(**texts: object) -> tuple[tuple[str, Template], ...]:
    """Return the named texts that are not None, as templates."""
    found = ((name, optional(text)) for name, text in texts.items())
    return tuple((name, text) for name, text in found if text is not None)
