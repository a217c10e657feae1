"""Base of the generators of CDR functions.

Each message type and direction gets one Python function, without branches that the type already
decides. A generator walks through the fields of a type, including those of nested messages,
collects runs of fixed-size values, and keeps track of the function's possible positions in the
data.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

from teleopctl.base.typed import Any, Callable, ClassVar, Iterator, contextmanager
from teleopctl.interfaces.blocks import BLOCK_CODES
from teleopctl.interfaces.cdr.layout import (
    ANYWHERE,
    MAXIMUM_ALIGNMENT,
    START,
    Layout,
    Offsets,
    Run,
)
from teleopctl.interfaces.definition import Definition, Field, FieldType, Shape

LARGE_ARRAY = 512
"""Size in bytes from which a fixed array is not part of a run, to avoid a second copy."""

_DEEPEST_LOOP = 8  # Python allows twenty nested blocks
_INDENT = "    "


class Generator(ABC):
    """Base of the two generators that write Python source for reading and writing CDR.

    Args:
        layout: Wire sizes of types.
        function: Function that returns the CDR function of a nested message type that is not
            inlined, by type name.

    Attributes:
        constants: Objects that the source refers to, by name.
        at: Possible positions of the function in the data, modulo 8.
    """

    function_name: ClassVar[str]
    parameters: ClassVar[str]
    order = "<"

    # Any, here and below: values of generated code.
    def __init__(self, layout: Layout, function: Callable[[str], Any]) -> None:
        self.layout = layout
        self.constants: dict[str, Any] = {}
        self._names: dict[Any, str] = {}
        self._function = function
        self._lines: list[str] = []
        self._depth = 0
        self._loops = 0
        self._numbers: dict[str, int] = {}
        self._run = Run()
        self._values: list[str] = []
        self.at: Offsets = ANYWHERE

    # Specific to reading or writing

    @abstractmethod
    def emit_body(self, definition: Definition) -> None:
        """Emit the code that reads or writes the whole message of a definition."""

    @abstractmethod
    def emit_run(self, run: Run, values: list[str], at: Offsets) -> None:
        """Emit the code that reads or writes a run of fixed-size values."""

    @abstractmethod
    def emit_value(self, kind: FieldType, place: str) -> None:
        """Emit the code for a single number, bool, byte or string."""

    @abstractmethod
    def emit_fixed_array(self, kind: FieldType, place: str) -> None:
        """Emit the code for a fixed array of numbers, bools or bytes."""

    @abstractmethod
    def emit_sequence(self, kind: FieldType, place: str) -> None:
        """Emit the code for a sequence of numbers, bools or bytes."""

    @abstractmethod
    def emit_elements(self, kind: FieldType, place: str) -> None:
        """Emit the code for an array or sequence of strings or messages."""

    @abstractmethod
    def emit_nested(self, kind: FieldType, place: str) -> None:
        """Emit the code for a nested message."""

    # Common to reading and writing

    def emit_fields(self, definition: Definition, variable: str) -> None:
        """Emit the code for all fields of the message that a variable holds."""
        if not definition.fields:
            self._run.add("x")
        for field in definition.fields:
            self._field(field, f"{variable}._{field.attribute}")

    def _field(self, field: Field, place: str) -> None:
        kind = field.type
        if kind.shape is Shape.SINGLE:
            if kind.is_nested:
                self.emit_nested(kind, place)
            else:
                self.emit_value(kind, place)
        elif kind.base not in BLOCK_CODES:
            self.emit_elements(kind, place)
        elif kind.shape is Shape.ARRAY:
            self.emit_fixed_array(kind, place)
        else:
            self.emit_sequence(kind, place)

    def add_value(self, code: str, text: str) -> None:
        """Append a value, by struct code and source text, to the current run."""
        self._run.add(code)
        self._values.append(text)

    def add_array(self, kind: FieldType, text: str) -> None:
        """Append a fixed array, by field type and source text, to the current run."""
        self._run.add_block(BLOCK_CODES[kind.base], kind.capacity)
        self._values.append(text)

    def add_valueless_byte(self) -> None:
        """Append a byte without a value, such as a string's final zero, to the run."""
        self._run.add("x")

    def flush(self) -> None:
        """Emit the code of the current run of values, if it has any, and start a new run."""
        if self._run:
            self.emit_run(self._run, self._values, self.at)
            self.at = self._run.ends(self.at)
            self._run, self._values = Run(), []

    def forget_position(self) -> None:
        """Mark that the position in the data depends on the content from here on."""
        self.at = ANYWHERE

    def struct_method(self, run: Run, method: str, at: Offsets) -> tuple[str, int | None]:
        """Return the code's name for a run's struct method, and the struct's size if fixed.

        Returns:
            The name of the method, and the size of the struct in bytes. If the struct depends on
            the position: None instead of the size, and the name of a table by position modulo 8,
            of methods for ``pack``, else of pairs of method and size.
        """
        structs = {start: run.struct_at(start, self.order) for start in at}
        if len(set(structs.values())) == 1:
            (struct,) = set(structs.values())
            return self.constant(method, getattr(struct, method)), struct.size
        table: list[Any] = [None] * MAXIMUM_ALIGNMENT
        for start, struct in structs.items():
            call = getattr(struct, method)
            table[start] = call if method == "pack" else (call, struct.size)
        return self.constant("table", tuple(table)), None

    @contextmanager
    def loop(self, head: str) -> Iterator[None]:
        """Emit a loop over elements; what is emitted in the ``with`` block is its body."""
        self.flush()
        before = self.at
        self._loops += 1
        self.at = ANYWHERE
        with self.indented(head):
            yield
            self.flush()
        self._loops -= 1
        self.at |= before

    @contextmanager
    def indented(self, head: str) -> Iterator[None]:
        """Emit a line; the ``with`` block emits the indented lines below it."""
        self.emit_line(head)
        self._depth += 1
        yield
        self._depth -= 1

    def inlines(self, type_name: str, is_element: bool = False) -> bool:
        """Return whether the code of a nested message is inlined rather than called."""
        return self._loops < _DEEPEST_LOOP and self.layout.is_inlined(type_name, is_element)

    def nested_function(self, type_name: str) -> str:
        """Return the name under which the code calls the function of a nested message."""
        return self.constant("message", self._function(type_name))

    def constant(self, prefix: str, value: Any) -> str:
        """Return the name of an object in the generated code; define a name for a new object."""
        name = self._names.get(value)
        if name is None:
            name = self._names[value] = self.unused_name(prefix.upper())
            self.constants[name] = value
        return name

    def unused_name(self, prefix: str) -> str:
        """Return a variable name with a prefix that the code does not use yet."""
        number = self._numbers[prefix] = self._numbers.get(prefix, -1) + 1
        return f"{prefix}_{number}"

    def emit_line(self, text: str) -> None:
        """Emit one line of generated code at the present indentation."""
        self._lines.append(f"{_INDENT * (self._depth + 1)}{text}\n")

    def function_source(self, name: str, is_nested: bool) -> str:
        """Return the Python source of a type's read or write function; to be called once.

        Args:
            name: Full name of the type.
            is_nested: Whether the function is for nested messages, which may start at any position
                in the data.
        """
        self.at = ANYWHERE if is_nested else START
        self.emit_body(self.layout.definition(name))
        return f"def {self.function_name}({self.parameters}):\n{''.join(self._lines)}"
