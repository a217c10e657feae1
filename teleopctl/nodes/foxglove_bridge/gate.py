"""Access check in front of the Foxglove SDK's server, which does not check origins or tokens.

The SDK does not expose the handshake and listens on TCP only. So the gate listens on the bridge's
address, reads the head of each request, checks it with `teleopctl.base.access`, and then relays
bytes between the client and the SDK's server without parsing them.

The SDK's own port must not bypass the gate. On Linux a socket filter in the kernel accepts packets
from the gate's own connections only, and drops those of other users and of web pages. On other
systems the port is on an address that no page can name or guess; see `inner_addresses`.
"""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import os
import secrets
import socket
import ssl
import struct
import sys
import threading
from collections.abc import Callable, Iterator
from http import HTTPStatus
from typing import TYPE_CHECKING

from teleopctl.base.access import Access, Answer
from teleopctl.errors import UnavailableError

if TYPE_CHECKING:
    from websockets.http11 import Request

# In bytes: a browser's request head is 1 kB; cookies of other programs on the host may add to it.
_LONGEST_HEAD = 32 * 1024
_HEAD_WITHIN_S = 10.0
_MOST_HANDSHAKES = 200
# In bytes: about one image, so that a slow client receives new messages. The SDK drops older ones.
_CHUNK = 256 * 1024
# Linux: asm-generic/socket.h and linux/filter.h.
_SO_ATTACH_FILTER = 26
_LOAD_SOURCE_PORT = (0x28, 0, 0, 0)  # BPF_LD | BPF_H | BPF_ABS: a TCP header begins with it
_DROP, _KEEP = (0x06, 0, 0, 0), (0x06, 0, 0, 0xFFFFFFFF)  # BPF_RET
_JUMP_IF_EQUAL = 0x15  # BPF_JMP | BPF_JEQ
# A filter has at most 4096 instructions, and a jump skips at most 255 of them.
_MOST_CLIENTS = 250


def inner_addresses() -> Iterator[str]:
    """Yield loopback addresses for the Foxglove SDK's server, the hardest for web pages first.

    Pages in a browser can connect to any port of 127.0.0.1. On Linux and Windows all 16 million
    addresses of 127.0.0.0/8 are this machine. On macOS only 127.0.0.1 is, but the link-local
    address of the loopback device has a zone, which a URL in a browser cannot contain.
    """
    if sys.platform == "darwin":
        with contextlib.suppress(OSError):
            yield f"[fe80::1%{socket.if_nametoindex('lo0')}]"
    else:
        yield "127." + ".".join(str(secrets.randbelow(254) + 1) for _ in range(3))
    yield "127.0.0.1"


class Gate:
    """TCP listener that checks each Foxglove client's access, then relays to the SDK's server.

    Args:
        access: Access check of the requests.
        host: Address to listen on.
        port: Port to listen on; 0 for any free one.
        inner: Address, from `inner_addresses`, and port of the SDK's server.
        tls: TLS context with the certificate; None for unencrypted connections.
        on_refused: Called in the gate's thread with the text of the answer, when a client is
            refused with status 403.

    Attributes:
        port: Port that the gate listens on.

    Raises:
        UnavailableError: The gate cannot listen on the address and port.
    """

    def __init__(
        self,
        access: Access,
        host: str,
        port: int,
        inner: tuple[str, int],
        tls: ssl.SSLContext | None,
        on_refused: Callable[[str], object],
    ) -> None:
        self.access = access
        self.on_refused = on_refused
        self.inner = _SdkPort(*inner)
        self.clients: set[_Client] = set()
        self.handshakes = 0
        self.loop = asyncio.new_event_loop()
        within = None if tls is None else _HEAD_WITHIN_S
        try:
            self._server = self.loop.run_until_complete(
                self.loop.create_server(
                    lambda: _Client(self), host, port, ssl=tls, ssl_handshake_timeout=within
                )
            )
        except OSError as error:
            self.loop.close()
            self.inner.close()
            raise UnavailableError(
                f"Cannot listen on {host}:{port}: {error.strerror or error}",
                hint="Choose another port: --ros-args -p port:=8766",
            ) from error
        self.port: int = self._server.sockets[0].getsockname()[1]
        self._thread = threading.Thread(target=self.loop.run_forever, name="gate", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Close the listening socket and all connections, and stop the thread."""
        asyncio.run_coroutine_threadsafe(self._end(), self.loop).result()
        self.loop.call_soon_threadsafe(self.loop.stop)
        self._thread.join()
        self.loop.close()
        self.inner.close()

    async def _end(self) -> None:
        self._server.close()
        for client in list(self.clients):
            client.end()
        tasks = asyncio.all_tasks() - {asyncio.current_task()}
        await asyncio.gather(*tasks, return_exceptions=True)


class _Relay(asyncio.Protocol):
    """One side of a forwarded connection; received bytes go to the other side.

    Attributes:
        transport: Transport of this side.
        other: Other side of the connection; None before it is connected.
    """

    transport: asyncio.Transport
    other: _Relay | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self.transport = transport
        transport.set_write_buffer_limits(high=_CHUNK)

    def data_received(self, data: bytes) -> None:
        if self.other is not None:
            self.other.transport.write(data)

    def pause_writing(self) -> None:
        if self.other is not None:
            self.other.transport.pause_reading()

    def resume_writing(self) -> None:
        if self.other is not None:
            self.other.transport.resume_reading()

    def connection_lost(self, error: Exception | None) -> None:
        del error  # disconnected clients are normal
        if self.other is not None:
            self.other.transport.close()


class _Client(_Relay):
    """Connection of a client: its request is checked, then forwarded.

    Args:
        gate: Gate that accepted the connection.
    """

    def __init__(self, gate: Gate) -> None:
        self._gate = gate
        self._head: bytearray | None = bytearray()

    def end(self) -> None:
        """Abort the client's connection at once."""
        self.transport.abort()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self._gate.clients.add(self)
        self._gate.handshakes += 1
        self._deadline = self._gate.loop.call_later(_HEAD_WITHIN_S, self.end)
        if self._gate.handshakes > _MOST_HANDSHAKES:
            self.end()

    def data_received(self, data: bytes) -> None:
        if self._head is None:
            super().data_received(data)
            return
        self._head += data
        # A head that arrives in small pieces is searched again for each piece, so its length and
        # its time are limited.
        if b"\r\n\r\n" not in self._head and len(self._head) <= _LONGEST_HEAD:
            return
        head, self._head = bytes(self._head), None
        self._decided()
        answer = self._decide(head)
        if answer is not None:
            self._answer(answer)
            return
        self.transport.pause_reading()
        self._leading = self._gate.loop.create_task(self._lead(head))

    def connection_lost(self, error: Exception | None) -> None:
        super().connection_lost(error)
        self._gate.clients.discard(self)
        if self._head is not None:
            self._decided()

    def _decided(self) -> None:
        self._deadline.cancel()
        self._gate.handshakes -= 1

    def _decide(self, head: bytes) -> Answer | None:
        request = _parse(head) if len(head) <= _LONGEST_HEAD else None
        if request is None:
            return Answer(HTTPStatus.BAD_REQUEST, "This is not an HTTP request.\n")
        answer = self._gate.access.check(request.path, request.headers.raw_items())
        if answer is not None and answer.status == HTTPStatus.FORBIDDEN:
            self._gate.on_refused(answer.text.strip())
        return answer

    def _answer(self, answer: Answer) -> None:
        body = answer.text.encode()
        headers = (
            ("Content-Type", "text/plain; charset=utf-8"),
            ("Content-Length", str(len(body))),
            ("Connection", "close"),
            *answer.headers,
        )
        lines = [f"HTTP/1.1 {answer.status.value} {answer.status.phrase}"]
        lines += [f"{name}: {value}" for name, value in headers]
        self.transport.write("\r\n".join(lines).encode() + b"\r\n\r\n" + body)
        self.transport.close()

    async def _lead(self, head: bytes) -> None:
        """Connect the client to the SDK's server, and forward the request to it."""
        inner = _ServerSide(self._gate.inner)
        inner.other = self
        try:
            await self._gate.inner.open(inner)
        except OSError:
            self._answer(Answer(HTTPStatus.SERVICE_UNAVAILABLE, "There are too many clients.\n"))
            return
        if self.transport.is_closing():
            inner.transport.close()
            return
        self.other = inner
        inner.transport.write(head)
        self.transport.resume_reading()


class _ServerSide(_Relay):
    """The connection to the SDK's server that belongs to a client.

    Args:
        port: Port of the SDK's server.
    """

    def __init__(self, port: _SdkPort) -> None:
        self._port = port

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self._name = transport.get_extra_info("sockname")

    def connection_lost(self, error: Exception | None) -> None:
        super().connection_lost(error)
        self._port.release(self._name)


class _SdkPort:
    """The port of the SDK's server, to which only the gate can connect.

    Args:
        host: Address on which the SDK's server listens.
        port: Port of the SDK's server.
    """

    def __init__(self, host: str, port: int) -> None:
        self._address = socket.getaddrinfo(
            host.strip("[]"), port, type=socket.SOCK_STREAM, flags=socket.AI_NUMERICHOST
        )[0]
        self._listener = _listener_at(port) if sys.platform == "linux" else None
        if self._listener is not None:
            # Accepted connections inherit the buffer size.
            self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _CHUNK)
        self._ports: set[int] = set()
        self._admit()

    async def open(self, protocol: asyncio.Protocol) -> None:
        """Connect ``protocol`` to the SDK's server, from a port that the kernel filter admits.

        Raises:
            OSError: The server cannot be reached, or the gate has too many clients.
        """
        if len(self._ports) >= _MOST_CLIENTS:
            raise ConnectionRefusedError
        family, kind, _, _, address = self._address
        loop = asyncio.get_running_loop()
        own = socket.socket(family, kind)
        port = 0
        try:
            own.setblocking(False)
            own.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _CHUNK)
            if self._listener is not None:
                own.bind(("127.0.0.1", 0))
                port = own.getsockname()[1]
                self._ports.add(port)
                self._admit()
            async with asyncio.timeout(_HEAD_WITHIN_S):
                await loop.sock_connect(own, address)
            await loop.create_connection(lambda: protocol, sock=own)
        except BaseException:
            own.close()
            self._ports.discard(port)
            raise

    def release(self, local_address: tuple[str, int]) -> None:
        """Remove a closed connection's local port from those that the kernel filter admits.

        Args:
            local_address: Local address and port of the closed connection.
        """
        self._ports.discard(local_address[1])
        self._admit()

    def close(self) -> None:
        """Close this process's duplicate of the SDK server's listening socket."""
        if self._listener is not None:
            self._listener.close()

    def _admit(self) -> None:
        """Make the kernel drop packets that do not come from our own connections' ports.

        While a connection is open, no other process can use its port. An accepted connection keeps
        the filter that was set when it was accepted.
        """
        if self._listener is None:
            return
        jumps = [
            (_JUMP_IF_EQUAL, len(self._ports) - number, 0, port)
            for number, port in enumerate(self._ports)
        ]
        program = b"".join(
            struct.pack("=HBBI", *instruction)
            for instruction in (_LOAD_SOURCE_PORT, *jumps, _DROP, _KEEP)
        )
        buffer = ctypes.create_string_buffer(program, len(program))
        filter_ = struct.pack("@HP", len(program) // 8, ctypes.addressof(buffer))
        self._listener.setsockopt(socket.SOL_SOCKET, _SO_ATTACH_FILTER, filter_)


def _listener_at(port: int) -> socket.socket:
    """Return a duplicate of the SDK's listening socket, which the SDK does not expose.

    Raises:
        UnavailableError: No open file of this process is that socket.
    """
    for name in os.listdir("/proc/self/fd"):  # noqa: PTH208 -- numbers, not files
        with contextlib.suppress(OSError):
            found = socket.socket(fileno=os.dup(int(name)))
            if found.getsockopt(socket.SOL_SOCKET, socket.SO_ACCEPTCONN):
                where = found.getsockname()
                if isinstance(where, tuple) and where[1] == port:
                    return found
            found.close()
    raise UnavailableError("The socket of Foxglove's SDK was not found")


def _parse(head: bytes) -> Request | None:
    """Read the head of a request as strictly as the page's server does; None for anything else."""
    from websockets.exceptions import SecurityError
    from websockets.http11 import Request
    from websockets.streams import StreamReader

    lines = StreamReader()
    lines.feed_data(head)
    try:
        next(Request.parse(lines.read_line))
    except StopIteration as parsed:
        return parsed.value if isinstance(parsed.value, Request) else None
    except (ValueError, EOFError, NotImplementedError, SecurityError):
        pass
    return None
