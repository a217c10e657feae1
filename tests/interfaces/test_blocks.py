"""Blocks of values in the slots of messages, in every form in which they come."""

import array
import copy
import itertools
import math
import pickle

import numpy as np
import pytest

from teleopctl.interfaces.blocks import TYPE_CODES
from teleopctl.interfaces.cdr import as_numpy, deserialize, serialize
from teleopctl.interfaces.store import add_definition_text, get_message

for base in [*TYPE_CODES, "bool", "byte"]:
    text = f"{base}[] sequence\n{base}[3] fixed\n"
    add_definition_text(f"block_cases/msg/{base.capitalize()}", text)


def forms(base: str, values: list) -> list:
    """Return messages with the same values, given and received in every way."""
    cls = get_message(f"block_cases/msg/{base.capitalize()}")
    code = TYPE_CODES[base]
    given = [values, tuple(values), array.array(code, values), np.array(values, np.dtype(code))]
    if base in ("uint8", "char"):
        given.append(bytes(values))
    messages = [cls(sequence=value, fixed=value) for value in given]
    messages += [deserialize(bytes(serialize(message)), cls) for message in messages]
    read = deserialize(bytes(serialize(messages[0])), cls)
    assert (read.sequence.tolist(), read.fixed.tolist()) == (values, values)
    return [*messages, read]


@pytest.mark.parametrize("base", TYPE_CODES)
def test_equal_values_are_equal_in_every_form(base):
    for one, other in itertools.product(forms(base, [1, 2, 3]), repeat=2):
        assert one == other
    for one, other in itertools.product(forms(base, [1, 2, 3]), forms(base, [1, 2, 4])):
        assert one != other


@pytest.mark.parametrize("base", ["float32", "float64"])
def test_floats_are_compared_as_numbers(base):
    for one, other in itertools.product(forms(base, [0.0] * 3), forms(base, [-0.0] * 3)):
        assert one == other
    cls = get_message(f"block_cases/msg/{base.capitalize()}")
    for values in ([math.nan] * 3, np.array([math.nan] * 3)):
        message = cls(fixed=values)
        assert message != deserialize(serialize(message), cls)


@pytest.mark.parametrize(
    ("base", "values"), [("bool", [True, False, True]), ("byte", [b"a", b"\0", b"\xff"])]
)
def test_bools_and_bytes_are_lists_however_they_came(base, values):
    cls = get_message(f"block_cases/msg/{base.capitalize()}")
    message = cls(sequence=values, fixed=values)
    received = deserialize(bytes(serialize(message)), cls)
    assert message == received
    assert received == message
    assert as_numpy(received, "sequence").tolist() == as_numpy(message, "sequence").tolist()
    assert (received.sequence, received.fixed) == (values, values)
    assert received == message
    received.sequence.append(values[0])
    assert received != message


@pytest.mark.parametrize("base", TYPE_CODES)
def test_a_received_message_can_be_copied_pickled_and_changed(base):
    cls = get_message(f"block_cases/msg/{base.capitalize()}")
    message = cls(sequence=[1, 2], fixed=[1, 2, 3])
    for remade in (copy.deepcopy, copy.copy, lambda m: pickle.loads(pickle.dumps(m))):
        assert remade(deserialize(bytes(serialize(message)), cls)) == message
    received = deserialize(bytes(serialize(message)), cls)
    received.sequence.append(3)
    received.fixed[0] = 9
    again = deserialize(serialize(received), cls)
    assert (again.sequence.tolist(), again.fixed.tolist()) == ([1, 2, 3], [9, 2, 3])
    assert message.fixed[0] == 1


def test_a_default_array_is_the_same_array_in_both_views():
    message = get_message("block_cases/msg/Float64")()
    view = as_numpy(message, "fixed")
    message.fixed[1] = 5.0
    assert view.tolist() == [0.0, 5.0, 0.0]
