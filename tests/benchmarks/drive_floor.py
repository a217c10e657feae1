"""Floor of the device and of the drive page: the same messages, without anything of teleopctl.

``python -m tests.benchmarks.drive_floor joy KEY PUT_KEY`` puts a payload of a TwistStamped's size
by Zenoh for each sample of a key; ``… page PORT PUT_KEY`` for each message of a websocket, whose
client gets a text of a state's size ten times a second.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import queue
import sys

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from teleopctl.wire import direct_callback, open_session

_TWIST, _ATTACHMENT = b"\0" * 84, b"\0" * 33
_STATE = json.dumps({"state": "x" * 700})


def main() -> None:
    """Run until it is killed."""
    kind, source, key = sys.argv[1:]
    session = open_session("peer")
    publisher = session.declare_publisher(key)
    if kind == "joy":
        samples: queue.SimpleQueue[object] = queue.SimpleQueue()
        subscriber = session.declare_subscriber(source, direct_callback(samples.put))
        while subscriber is not None:
            samples.get()
            publisher.put(_TWIST, attachment=_ATTACHMENT)

    async def answer(connection: ServerConnection) -> None:
        async def send() -> None:
            with contextlib.suppress(ConnectionClosed):
                while True:
                    await connection.send(_STATE)
                    await asyncio.sleep(0.1)

        sending = asyncio.create_task(send())
        with contextlib.suppress(ConnectionClosed):
            async for text in connection:
                json.loads(text)
                publisher.put(_TWIST, attachment=_ATTACHMENT)
        sending.cancel()

    async def run() -> None:
        async with serve(answer, "127.0.0.1", int(source)):
            await asyncio.get_running_loop().create_future()

    asyncio.run(run())


if __name__ == "__main__":
    main()
