"""Generator of the functions that read messages from CDR.

Received bytes are not trusted. A value beyond the end of the data, a count that the remaining bytes
cannot hold and a string without its NUL raise ValueError or ``struct.error``. Only strings and
short arrays are copied; blocks refer to the data.
"""

from __future__ import annotations

import sys

from teleopctl.base.typed import Any, Callable
from teleopctl.interfaces.blocks import BLOCK_CODES, ITEM_SIZES, byteswapped, empty
from teleopctl.interfaces.cdr.codegen import LARGE_ARRAY, Generator
from teleopctl.interfaces.cdr.layout import (
    HEADER_SIZE,
    Layout,
    Offsets,
    Run,
    after_block,
    padding,
)
from teleopctl.interfaces.definition import Definition, FieldType, Shape

_COUNT = "I"


class ReaderGenerator(Generator):
    """Generator of ``read(d, v, p, end)``, which returns a parsed message and the next position.

    ``d`` is the data, ``v`` a memoryview of the data, ``p`` the start position of the message, and
    ``end`` the length of the data.

    Args:
        layout: Wire sizes of types.
        function: Function that returns the CDR function of a nested message type that is not
            inlined, by type name.
        message_class: Function that returns the class of a message type by its full name.
        is_little: Whether the data is little-endian.
    """

    function_name = "read"
    parameters = "d, v, p, end"

    # Any: values of generated code.
    def __init__(
        self,
        layout: Layout,
        function: Callable[[str], Any],
        message_class: Callable[[str], type],
        is_little: bool,
    ) -> None:
        super().__init__(layout, function)
        self.order = "<" if is_little else ">"
        self._swapped = is_little != (sys.byteorder == "little")
        self._message_class = message_class
        self._after_run: list[str] = []

    def emit_body(self, definition: Definition) -> None:
        """Emit the code that reads the whole message of a definition."""
        self.constants.update(
            new=object.__new__, bad_text=_bad_text, bad_count=_bad_count, swapped=byteswapped
        )
        self.emit_line(f"m = {self._new(definition.type_name)}")
        self.emit_fields(definition, "m")
        self.flush()
        self.emit_line("return m, p")

    def emit_run(self, run: Run, values: list[str], at: Offsets) -> None:
        """Emit the code that reads a run of fixed-size values."""
        if run.is_single_pad():
            self.emit_line("p += 1")
            return
        name, size = self.struct_method(run, "unpack_from", at)
        if size is None:
            self.emit_line(f"unpack, size = {name}[p & 7]")
            name = "unpack"
        targets = f"{', '.join(values)}{',' if len(values) == 1 else ''} = " if values else ""
        self.emit_line(f"{targets}{name}(d, p)")
        self.emit_line(f"p += {'size' if size is None else size}")
        for text in self._after_run:
            self.emit_line(text)
        self._after_run = []

    def emit_nested(self, kind: FieldType, place: str) -> None:
        """Emit the code that reads one nested message."""
        if self.inlines(kind.base):
            variable = self.unused_name("m")
            self.emit_line(f"{variable} = {place} = {self._new(kind.base)}")
            self.emit_fields(self.layout.definition(kind.base), variable)
        else:
            self._call(kind, place)

    def _call(self, kind: FieldType, place: str) -> None:
        self.flush()
        self.emit_line(f"{place}, p = {self.nested_function(kind.base)}(d, v, p, end)")
        self.forget_position()

    def _new(self, type_name: str) -> str:
        return f"new({self.constant('class', self._message_class(type_name))})"

    def emit_value(self, kind: FieldType, place: str) -> None:
        """Emit the code that reads a single number, bool, byte or string."""
        if kind.base in BLOCK_CODES:
            self.add_value(BLOCK_CODES[kind.base], place)
            return
        self.add_value(_COUNT, "n")
        self.flush()
        if kind.base == "wstring":
            self._wide_string(kind, place)
            return
        self.emit_line("e = p + n - 1")
        with self.indented("if not p <= e < end or d[e]:"):
            self.emit_line("raise bad_text(n, p)")
        self.emit_line(f'{place} = str(d[p:e], "utf-8")')
        if kind.string_capacity:
            with self.indented(f"if len({place}) > {kind.string_capacity}:"):
                self.emit_line("raise bad_text(n, p)")
        self.emit_line("p = e")
        self.forget_position()
        self.add_valueless_byte()

    def _wide_string(self, kind: FieldType, place: str) -> None:
        self.emit_line("e = p + n * 2")
        with self.indented("if e > end:"):
            self.emit_line("raise bad_count(n, p)")
        # A single surrogate, which Python cannot print, becomes the replacement character U+FFFD.
        code = f"utf-16-{'le' if self.order == '<' else 'be'}"
        self.emit_line(f'{place} = str(d[p:e], "{code}", "replace")')
        if kind.string_capacity:
            with self.indented(f"if len({place}) > {kind.string_capacity}:"):
                self.emit_line("raise bad_count(n, p)")
        self.emit_line("p = e")
        self.forget_position()

    def emit_fixed_array(self, kind: FieldType, place: str) -> None:
        """Emit the code that reads a fixed array of numbers, bools or bytes."""
        item = ITEM_SIZES[BLOCK_CODES[kind.base]]
        if kind.capacity * item < LARGE_ARRAY:
            variable = self.unused_name("b")
            self.add_array(kind, variable)
            self._after_run.append(f"{place} = {self._view(kind, f'memoryview({variable})')}")
            return
        self.flush()
        self._slice(kind, place, str(kind.capacity))

    def emit_sequence(self, kind: FieldType, place: str) -> None:
        """Emit the code that reads a sequence of numbers, bools or bytes."""
        self.add_value(_COUNT, "n")
        self.flush()
        self._check_bound(kind)
        before = self.at
        with self.indented("if n:"):
            self._slice(kind, place, "n")
        with self.indented("else:"):
            self.constants[f"empty_{kind.base}"] = empty(kind.base)
            self.emit_line(f"{place} = empty_{kind.base}")
        self.at |= before

    def _slice(self, kind: FieldType, place: str, count: str) -> None:
        size = ITEM_SIZES[BLOCK_CODES[kind.base]]
        self._align(size)
        self.emit_line(f"e = p + {count} * {size}" if size > 1 else f"e = p + {count}")
        with self.indented("if e > end:"):
            self.emit_line(f"raise bad_count({count}, p)")
        self.emit_line(f"{place} = {self._view(kind, 'v[p:e]')}")
        self.emit_line("p = e")
        self.at = after_block(self.at, size)

    def emit_elements(self, kind: FieldType, place: str) -> None:
        """Emit the code that reads an array or a sequence of strings or messages."""
        count = str(kind.capacity)
        if kind.shape is not Shape.ARRAY:
            count = "n"
            self.add_value(_COUNT, count)
        self.flush()
        self._check_bound(kind)
        with self.indented(f"if {count} * {self.layout.element_minimum(kind)} > end - p:"):
            self.emit_line(f"raise bad_count({count}, p)")
        elements = self.unused_name("a")
        self.emit_line(f"{elements} = {place} = []")
        with self.loop(f"for _ in range({count}):"):
            if not kind.is_nested:
                self.emit_value(kind.element, "t")
                self.emit_line(f"{elements}.append(t)")
            elif self.inlines(kind.base, is_element=True):
                variable = self.unused_name("m")
                self.emit_line(f"{variable} = {self._new(kind.base)}")
                self.emit_line(f"{elements}.append({variable})")
                self.emit_fields(self.layout.definition(kind.base), variable)
            else:
                self._call(kind, "t")
                self.emit_line(f"{elements}.append(t)")

    def _check_bound(self, kind: FieldType) -> None:
        if kind.shape is Shape.BOUNDED:
            with self.indented(f"if n > {kind.capacity}:"):
                self.emit_line("raise bad_count(n, p)")

    def _view(self, kind: FieldType, data: str) -> str:
        code = BLOCK_CODES[kind.base]
        if self._swapped and ITEM_SIZES[code] > 1:
            return f"swapped({kind.base!r}, {data})"
        return data if code == "B" else f"{data}.cast({code!r})"

    def _align(self, size: int) -> None:
        """Emit the code that skips padding, if padding is possible at this position."""
        gaps = {padding(position, size) for position in self.at}
        if len(gaps) > 1:
            self.emit_line(f"p += ({HEADER_SIZE} - p) % {size}")
        elif gaps != {0}:
            self.emit_line(f"p += {gaps.pop()}")


def _bad_text(size: int, position: int) -> ValueError:
    return ValueError(f"string length {size} at byte {position} is wrong, or its end is not NUL")


def _bad_count(count: int, position: int) -> ValueError:
    return ValueError(f"sequence length {count} at byte {position} is too large")
