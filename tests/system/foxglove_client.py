"""Client of Foxglove's WebSocket protocol, written from the protocol's specification."""

from __future__ import annotations

import json
import struct
import time
from typing import Any

from websockets import Subprotocol
from websockets.sync.client import connect

from teleopctl.testing import LONGEST_WAIT_S

SUBPROTOCOL = Subprotocol("foxglove.sdk.v1")
MESSAGE, TIME, SERVICE_RESPONSE, ASSET = 1, 2, 3, 4


class FoxgloveClient:
    """Client that stores received messages, and waits for messages with a timeout."""

    def __init__(self, port: int) -> None:
        self._socket = connect(f"ws://127.0.0.1:{port}", subprotocols=[SUBPROTOCOL], max_size=None)
        self._last_subscribe = ""
        self.info: dict[str, Any] = {}
        self.channels: dict[str, dict[str, Any]] = {}
        self.services: dict[str, dict[str, Any]] = {}
        self.documents: list[dict[str, Any]] = []
        self.binaries: list[bytes] = []

    def __enter__(self) -> FoxgloveClient:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def send(self, op: str, **fields: Any) -> None:
        self._socket.send(json.dumps({"op": op, **fields}))

    def send_binary(self, op: int, data: bytes) -> None:
        self._socket.send(bytes([op]) + data)

    def until(self, answer):
        """Receive until ``answer()`` returns a true value, and return the value."""
        deadline = time.monotonic() + LONGEST_WAIT_S
        while not (found := answer()):
            left = deadline - time.monotonic()
            if left <= 0:
                raise AssertionError(f"never came; the last were {self.documents[-3:]}")
            try:
                self._take(self._socket.recv(timeout=left))
            except TimeoutError:
                continue
        return found

    def document(self, op: str, **fields: Any) -> Any:
        """Return and remove the first JSON message with an ``op`` and field values."""

        def look():
            for document in self.documents:
                if document["op"] == op and fields.items() <= document.items():
                    self.documents.remove(document)
                    return document
            return None

        return self.until(look)

    def binary(self, op: int) -> Any:
        """Remove the next binary message of an opcode; return its bytes after the opcode."""

        def look():
            for data in self.binaries:
                if data[0] == op:
                    self.binaries.remove(data)
                    return data
            return None

        return self.until(look)[1:]

    def subscribe(self, topic: str, number: int) -> None:
        channel = self.until(lambda: self.channels.get(topic))
        wish = {"op": "subscribe", "subscriptions": [{"id": number, "channelId": channel["id"]}]}
        self._last_subscribe = json.dumps(wish)
        self._socket.send(self._last_subscribe)

    def message(self) -> tuple[int, int, bytes]:
        """Return subscription number, time in nanoseconds and bytes of the next message."""
        data = self.binary(MESSAGE)
        number, stamp = struct.unpack_from("<IQ", data)
        return number, stamp, data[12:]

    def call(self, service: str, payload: bytes, encoding: str = "cdr") -> None:
        number = self.until(lambda: self.services.get(service))["id"]
        name = encoding.encode()
        self.send_binary(2, struct.pack("<III", number, 7, len(name)) + name + payload)

    def _take(self, received: str | bytes) -> None:
        if isinstance(received, bytes):
            self.binaries.append(received)
            return
        document = json.loads(received)
        match document["op"]:
            case "serverInfo":
                self.info = document
            case "advertise":
                self.channels.update({c["topic"]: c for c in document["channels"]})
            case "unadvertise":
                gone = document["channelIds"]
                self.channels = {t: c for t, c in self.channels.items() if c["id"] not in gone}
            case "advertiseServices":
                self.services.update({s["name"]: s for s in document["services"]})
            case "status" if "Unknown channel ID" in document["message"]:
                # The SDK advertises a channel before it accepts subscriptions to the channel.
                self._socket.send(self._last_subscribe)
            case _:
                self.documents.append(document)
