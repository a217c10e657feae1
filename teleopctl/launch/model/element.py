"""Elements of XML and YAML launch files: values with file, line and key."""

from __future__ import annotations

from teleopctl.base.typed import Any, ClassVar, Iterator, Mapping, Sequence
from teleopctl.errors import LaunchError, TeleopctlError
from teleopctl.launch.model import template
from teleopctl.launch.model.descriptions import Place
from teleopctl.launch.model.records import dataclass


@dataclass(frozen=True, slots=True)
class Element:
    """Value in a launch file: scalar, list or mapping, with its file, line and key.

    Subclasses for other languages override methods such as `fields`, `action` and `typed`. All code
    after the front ends is independent of the language.

    Attributes:
        noun: Noun for the element in messages.
        value: A scalar, a list of elements, or a dictionary of elements by key; of any type, since
            a file may contain anything.
        place: File and line of the element.
        path: Keys that lead to the element, for messages.
    """

    noun: ClassVar[str] = "key"

    value: Any
    place: Place
    path: str

    def error(self, message: str, hint: str | None = None) -> TeleopctlError:
        """Return an error whose message begins with the element's file, line and key."""
        where = f" '{self.path}':" if self.path else ""
        return LaunchError(f"{self.place}:{where} {message}", hint=hint)

    def fields(self, keys: Sequence[str]) -> Mapping[str, Element]:
        """Return the elements of an entry by key; a plain list is the key ``children``.

        Args:
            keys: Keys that the entry may have. Other keys of the entry are returned, too.

        Raises:
            TeleopctlError: The value is not a mapping.
        """
        if self.value is None:
            return {}
        if isinstance(self.value, list) and "children" in keys:
            # The short form: a list of children and nothing else.
            return {"children": self}
        return self.mapping(f"a mapping with {', '.join(keys)}")

    def action(self) -> tuple[str, Element]:
        """Return the name and the content of the only action in a mapping.

        Raises:
            TeleopctlError: The value is not a mapping with exactly one key.
        """
        fields = self.mapping("an action, such as 'node: …'")
        if len(fields) != 1:
            raise self.error(
                f"expected one action, got {self.describe()}",
                hint="What belongs to an action is indented below its name.",
            )
        return next(iter(fields.items()))

    def typed(self) -> Element:
        """Return the element itself, whose value YAML has typed; XML attributes parse a text."""
        return self

    def flag(self) -> bool:
        """Return the value as a boolean; raise for anything else.

        Raises:
            TeleopctlError: The value is not a boolean.
        """
        value = self.typed().value
        if not isinstance(value, bool):
            raise self.error(f"expected true or false, got {self.describe()}")
        return value

    def mapping(self, expected: str) -> dict[str, Element]:
        """Return the value if it is a mapping; else raise an error that names ``expected``.

        Raises:
            TeleopctlError: The value is not a mapping.
        """
        if not isinstance(self.value, dict):
            raise self.error(f"expected {expected}, got {self.describe()}")
        return self.value

    def items(self, expected: str) -> Iterator[Element]:
        """Yield the items if the value is a list; else raise an error that names ``expected``.

        Raises:
            TeleopctlError: The value is not a list.
        """
        if not isinstance(self.value, list):
            raise self.error(f"expected {expected}, got {self.describe()}")
        yield from self.value

    def text(self) -> str:
        """Return a scalar as a string, booleans as ``true`` or ``false``; raise for other values.

        Raises:
            TeleopctlError: The value is not a scalar.
        """
        if isinstance(self.value, bool):
            return "true" if self.value else "false"
        if isinstance(self.value, str | int | float):
            return str(self.value)
        raise self.error(f"expected a text, got {self.describe()}")

    def template(self) -> template.Template:
        """Return the value as a template with substitutions; numbers and booleans as literal text.

        Raises:
            TeleopctlError: The value is not a scalar, or its substitutions are malformed.
        """
        if not isinstance(self.value, str):
            return template.literal(self.text())
        try:
            return template.parse(self.value)
        except template.TemplateError as error:
            raise self.error(str(error)) from error

    def describe(self) -> str:
        """Return a description of the value, for error messages."""
        if isinstance(self.value, dict):
            return "a mapping with " + (", ".join(self.value) or "nothing in it")
        if isinstance(self.value, list):
            return f"a list of {len(self.value)}"
        return "nothing" if self.value is None else repr(self.value)
