"""Generator of the functions that write messages as little-endian CDR.

A function appends to a bytearray, whose length is the current position. A large block of numbers is
copied once, by ``extend``; with a numpy array, ``+=`` would be numpy's addition.
"""

from __future__ import annotations

import sys

from teleopctl.base.typed import Any
from teleopctl.interfaces.blocks import BLOCK_CODES, ITEM_SIZES, byteswapped
from teleopctl.interfaces.cdr.codegen import LARGE_ARRAY, Generator
from teleopctl.interfaces.cdr.layout import HEADER_SIZE, Offsets, Run, after_block, padding
from teleopctl.interfaces.definition import Definition, FieldType, Shape

_COUNT = "I"
_SWAPPED = sys.byteorder == "big"


class WriterGenerator(Generator):
    """Generator of ``write(out, m)``, which appends message ``m`` to bytearray ``out``."""

    function_name = "write"
    parameters = "out, m"

    def emit_body(self, definition: Definition) -> None:
        """Emit the code that writes the whole message of a definition."""
        self.constants.update(
            fixed=_fixed, listed=_listed, swapped=_swapped, ValueError=ValueError, zeros=bytes(8)
        )
        self.emit_fields(definition, "m")
        self.flush()

    def emit_run(self, run: Run, values: list[str], at: Offsets) -> None:
        """Emit the code that writes a run of fixed-size values."""
        if run.is_single_pad():
            self.emit_line("out.append(0)")
            return
        name, size = self.struct_method(run, "pack", at)
        pack = f"{name}[len(out) & 7]" if size is None else name
        self.emit_line(f"out += {pack}({', '.join(values)})")

    def emit_nested(self, kind: FieldType, place: str) -> None:
        """Emit the code that writes one nested message."""
        if self.inlines(kind.base):
            variable = self.unused_name("m")
            self.emit_line(f"{variable} = {place}")
            self.emit_fields(self.layout.definition(kind.base), variable)
        else:
            self._call(kind, place)

    def _call(self, kind: FieldType, place: str) -> None:
        self.flush()
        self.emit_line(f"{self.nested_function(kind.base)}(out, {place})")
        self.forget_position()

    def emit_value(self, kind: FieldType, place: str) -> None:
        """Emit the code that writes a single number, bool, byte or string."""
        if kind.base in BLOCK_CODES:
            self.add_value(BLOCK_CODES[kind.base], place)
            return
        text = self.unused_name("t")
        is_wide = kind.base == "wstring"
        code = '"utf-16-le"' if is_wide else ""
        self.emit_line(f"{text} = {place}.encode({code})")
        self.add_value(_COUNT, f"len({text}) >> 1" if is_wide else f"len({text}) + 1")
        self.flush()
        self.emit_line(f"out += {text}")
        self.forget_position()
        if not is_wide:
            self.add_valueless_byte()

    def emit_fixed_array(self, kind: FieldType, place: str) -> None:
        """Emit the code that writes a fixed array of numbers, bools or bytes."""
        size = kind.capacity * ITEM_SIZES[BLOCK_CODES[kind.base]]
        data = self._data(kind, place)
        if size < LARGE_ARRAY:
            self.add_array(kind, f"fixed({data}, {size})")
            return
        self.flush()
        variable = self.unused_name("v")
        self.emit_line(f"{variable} = fixed({data}, {size})")
        self._align(ITEM_SIZES[BLOCK_CODES[kind.base]])
        self.emit_line(f"out += {variable}")
        self.at = after_block(self.at, ITEM_SIZES[BLOCK_CODES[kind.base]])

    def emit_sequence(self, kind: FieldType, place: str) -> None:
        """Emit the code that writes a sequence of numbers, bools or bytes."""
        size = ITEM_SIZES[BLOCK_CODES[kind.base]]
        block, count = self.unused_name("v"), self.unused_name("n")
        self.emit_line(f"{block} = {self._data(kind, place)}")
        self.emit_line(f"{count} = len({block})")
        self._check_bound(kind, count)
        self.add_value(_COUNT, count)
        self.flush()
        before = self.at
        with self.indented(f"if {count}:"):
            self._align(size)
            self.emit_line(f"end = len(out) + {count} * {size}")
            self.emit_line(f"out.extend({block})")
            with self.indented("if len(out) != end:"):
                self.emit_line('raise ValueError("it changed while it was serialised")')
        self.at = before | after_block(self.at, size)

    def emit_elements(self, kind: FieldType, place: str) -> None:
        """Emit the code that writes an array or a sequence of strings or messages."""
        elements = self.unused_name("v")
        self.emit_line(f"{elements} = [*{place}]")
        if kind.shape is Shape.ARRAY:
            with self.indented(f"if len({elements}) != {kind.capacity}:"):
                self.emit_line(f'raise ValueError("an array has not {kind.capacity} elements")')
        else:
            self._check_bound(kind, f"len({elements})")
            self.add_value(_COUNT, f"len({elements})")
        element = self.unused_name("e")
        with self.loop(f"for {element} in {elements}:"):
            if not kind.is_nested:
                self.emit_value(kind.element, element)
            elif self.inlines(kind.base, is_element=True):
                self.emit_fields(self.layout.definition(kind.base), element)
            else:
                self._call(kind, element)

    def _data(self, kind: FieldType, place: str) -> str:
        if not kind.is_numeric:
            return f"listed({place}, {kind.base == 'byte'})"
        return f"swapped({kind.base!r}, {place})" if _SWAPPED else place

    def _check_bound(self, kind: FieldType, count: str) -> None:
        if kind.shape is Shape.BOUNDED:
            with self.indented(f"if {count} > {kind.capacity}:"):
                self.emit_line(
                    f'raise ValueError("a sequence has more than {kind.capacity} elements")'
                )

    def _align(self, size: int) -> None:
        """Emit the code that writes padding, if padding is possible at this position."""
        gaps = {padding(position, size) for position in self.at}
        if len(gaps) > 1:
            self.emit_line(f"out += zeros[: ({HEADER_SIZE} - len(out)) % {size}]")
        elif gaps != {0}:
            self.emit_line(f"out += zeros[: {gaps.pop()}]")


def _fixed(block: Any, size: int) -> bytes:
    """Return a fixed array as bytes."""
    data: bytes = block if isinstance(block, bytes) else block.tobytes()
    if len(data) != size:
        raise ValueError(f"an array has {len(data)} bytes instead of {size}")
    return data


def _listed(block: Any, is_bytes: bool) -> Any:
    """Return a list of bools or bytes as a block; return a block unchanged."""
    if not isinstance(block, list):
        return block
    data = b"".join(block) if is_bytes else bytes(map(bool, block))
    if len(data) != len(block):
        raise ValueError("a byte is not one byte")
    return data


def _swapped(base: str, block: Any) -> Any:
    return byteswapped(base, memoryview(block).cast("B"))
