"""Invalid messages for the page's websocket, which the page's own client would not send."""

from __future__ import annotations

import random
from collections.abc import Iterator

import msgspec
import viser
from viser import _messages
from viser.infra import Message
from websockets import Subprotocol
from websockets.sync.client import connect

PROTOCOL = Subprotocol(f"viser-v{viser.__version__}")
_VALUES: tuple[object, ...] = (
    *(None, True, 0, -1, 1 << 62, 1.5, float("nan"), "", "x" * 300, b"\xff", [], {}),
    *([None], {"a": []}, (1, 2), [[[[]]]], {"__binary_index": 5}),
)


def garbage(count: int) -> Iterator[bytes | str]:
    """Yield invalid messages of all types, the same in each run."""
    chance = random.Random(20)
    kinds = sorted(Message.get_subclasses(), key=lambda kind: kind.__name__)
    assert _messages  # the module that defines the classes
    for number in range(count):
        kind = kinds[number % len(kinds)]
        names = list(getattr(kind, "__dataclass_fields__", {}))
        match number % 6:
            case 0:
                yield chance.randbytes(chance.randrange(200))
            case 1:
                yield "text" * chance.randrange(50)
            case 2:
                yield msgspec.msgpack.encode(chance.choice(_VALUES))
            case 3:
                yield msgspec.msgpack.encode({"type": chance.choice(["", "Message", "x" * 999])})
            case _:
                chosen = chance.sample(names, chance.randrange(len(names) + 1))
                fields = {
                    name: chance.choice(_VALUES) for name in (chosen if number % 2 else names)
                }
                yield msgspec.msgpack.encode({"type": kind.__name__, **fields})


def send_garbage(port: int, count: int) -> None:
    """Send each message over a new connection, since the page may close one after a message."""
    for message in garbage(count):
        with connect(f"ws://127.0.0.1:{port}/", subprotocols=[PROTOCOL], max_size=None) as client:
            client.send(message)
