"""CDR of every known type, and of types as awkward as can be, against rosbags' CDR."""

from functools import cache
from random import Random, SystemRandom

import pytest
from hypothesis import given, settings

from teleopctl.interfaces.blocks import BLOCK_CODES
from teleopctl.interfaces.cdr import deserialize, serialize
from teleopctl.interfaces.store import (
    add_definition_text,
    get_action,
    get_message,
    get_service,
    list_types,
)
from tests.interfaces.messages import messages, random_message
from tests.interfaces.oracle import foreign_bytes
from tests.samples import is_nightly, sample

# In the nightly profile more messages, and others each time; see tests/conftest.py.
SEED = SystemRandom().getrandbits(32) if is_nightly() else None
ROUNDS = 40 if is_nightly() else 1

# Before this and other tests add their own.
KNOWN = {kind: list_types(kind) for kind in ("msg", "srv", "action")}


@cache
def type_names() -> list[str]:
    """Return names of message types that come with teleopctl, and of their parts: a sample."""
    classes = [get_message(name) for name in sample(KNOWN["msg"], 10)]
    for name in sample(KNOWN["srv"], 10):
        service = get_service(name)
        classes += [service.Request, service.Response, service.Event]
    for name in sample(KNOWN["action"], 10):
        action = get_action(name)
        classes += [action.Goal, action.Result, action.Impl.FeedbackMessage]
        for service in (action.Impl.SendGoalService, action.Impl.GetResultService):
            classes += [service.Request, service.Response]
    return sorted({cls.TYPE_NAME for cls in classes})


SHAPES = {
    "Inner": "uint8 a\nfloat64 b\nstring c\nuint8 d\n",
    "Fixed": "uint8 a\nfloat64 b\nint16 c\n",
    "Empty": "",
    # Every kind of value behind one that leaves the alignment in doubt.
    "Singles": "\n".join(f"string text_{base}\n{base} value_{base}" for base in BLOCK_CODES),
    "Sequences": "\n".join(
        f"{base}[] value_{base}\nuint8 after_{base}" for base in [*BLOCK_CODES, "string"]
    ),
    "Arrays": "\n".join(
        f"uint8 before_{base}\n{base}[3] value_{base}" for base in [*BLOCK_CODES, "string"]
    ),
    "LongArrays": "string a\nuint8[1001] b\nfloat64[100] c\nbool[600] d\nint16[300] e\nuint8 f\n",
    "Bounded": "string<=3 a\nstring<=3[<=2] b\nint64[<=2] c\nbyte[<=3] d\nbool[<=1] e\n",
    "Nested": "uint8 a\nInner b\nInner[] c\nInner[2] d\nFixed e\nFixed[] f\nFixed[3] g\nEmpty h\n",
    "Empties": "Empty[] a\nEmpty[2] b\nEmpty c\nfloat64 d\nEmpty e\n",
    # Sequences in sequences, deeper than the generator puts into one function.
    **{f"Deep{n}": f"uint8 a\nDeep{n + 1}[] b\nfloat64 c\n" for n in range(12)},
    "Deep12": "string a\n",
    # More fields than it puts into one function.
    "Wide": "".join(f"int16 a{n}\nstring b{n}\n" for n in range(40)),
    "Wides": "uint8 a\nWide b\nWide[] c\nWide[2] d\nuint64 e\n",
    **{f"Double{n}": f"Double{n + 1} a\nDouble{n + 1} b\n" for n in range(8)},
    "Double8": "uint8 a\nfloat64 b\n",
}
for shape, text in SHAPES.items():
    add_definition_text(f"shape_cases/msg/{shape}", text)


@cache
def has_wide_string(name: str) -> bool:
    kinds = [field.type for field in get_message(name).__definition__.fields]
    return any(
        has_wide_string(kind.base) if kind.is_nested else kind.base == "wstring" for kind in kinds
    )


@pytest.mark.parametrize("kind", ["msg", "srv", "action"])
def test_types_have_the_bytes_of_rosbags(kind):
    for name in type_names():
        if f"/{kind}/" in name and not has_wide_string(name):  # rosbags has no wstring
            check_some(name, ROUNDS)


@pytest.mark.parametrize("shape", SHAPES)
def test_every_shape_has_the_bytes_of_rosbags(shape):
    rounds = ROUNDS if shape.startswith("Double") else 20 * ROUNDS
    check_some(f"shape_cases/msg/{shape}", rounds)


def check_some(name, rounds):
    """Check random messages of a type; of those that fail, tell the smallest.

    The generator is quicker than a strategy for each type: of four messages of each of 875 types,
    1.1 s of processor time instead of 6.9 s. The strategy is there for the type that fails.
    """
    source = Random(SEED or name)
    for _ in range(rounds):
        message = random_message(source, name)
        try:
            check(message)
        except Exception:
            settings(max_examples=1000, database=None)(given(messages(name))(check))()
            raise


def check(message):
    little, big = foreign_bytes(message, little=True), foreign_bytes(message, little=False)
    assert serialize(message) == little, message
    for data in (little, big):
        received = deserialize(data, type(message))
        assert received == message
        assert serialize(received) == little
        assert repr(received) == repr(message)
        assert serialize(received) == little  # now that every field was read
