"""``teleopctl multicast``: UDP multicast datagrams, as ``ros2 multicast`` sends them."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option, Verb, VerbGroup
from teleopctl.errors import SystemFailureError, UsageError

if TYPE_CHECKING:
    import socket


GROUP = VerbGroup(
    "Send and receive datagrams to many machines.",
    {
        "receive": Verb(f"{__name__}:receive", "Receive a single datagram."),
        "send": Verb(f"{__name__}:send", "Send a single datagram."),
    },
)


MULTICAST_GROUP = "225.0.0.1"
MULTICAST_PORT = 49150
_LARGEST = 4096


def send_datagram(
    data: bytes, group: str = MULTICAST_GROUP, port: int = MULTICAST_PORT, ttl: int | None = None
) -> None:
    """Send a datagram to a multicast group.

    Args:
        data: Content of the datagram.
        group: Multicast group: an IPv4 address from 224.0.0.0 to 239.255.255.255.
        port: UDP port of the receivers.
        ttl: Time to live: number of routers that the datagram may pass; None for the default.

    Raises:
        SystemFailureError: This machine cannot send to the group.
        UsageError: The group or port is invalid.
    """
    import socket

    with _checked(group, port), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        if ttl is not None:
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, ttl)
        sender.sendto(data, (group, port))


@contextmanager
def open_receiver(
    group: str = MULTICAST_GROUP, port: int = MULTICAST_PORT
) -> "Iterator[socket.socket]":
    """Yield a socket that receives the datagrams of a multicast group.

    Raises:
        SystemFailureError: This machine cannot join the group.
        UsageError: The group or port is invalid.
    """
    import socket
    import struct

    with _checked(group, port), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        with suppress(AttributeError):  # Windows has no such option
            receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        receiver.bind(("", port))
        membership = struct.pack("=4sL", socket.inet_aton(group), socket.INADDR_ANY)
        receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        yield receiver


def receive_datagram(receiver: "socket.socket") -> tuple[str, str, int]:
    """Block until a datagram arrives on a socket; return text, sender's host and port."""
    data, (host, port) = receiver.recvfrom(_LARGEST)
    return data.decode(errors="replace"), host, port


@contextmanager
def _checked(group: str, port: int) -> Iterator[None]:
    import socket

    try:
        if not 224 <= socket.inet_aton(group)[0] <= 239:
            raise UsageError(
                f"{group} is not a multicast group: expected 224.0.0.0 to 239.255.255.255"
            )
        if not 0 < port < 65536:
            raise UsageError(f"{port} is not a port: expected 1 to 65535")
        yield
    except OSError as error:
        if isinstance(error, TimeoutError):
            raise
        raise SystemFailureError(
            f"Cannot use the multicast group {group}, port {port}: {error.strerror or error}"
        ) from error


_GREETING = "Hello World!"

_Group = Annotated[str, Option("--group", help="The group of receivers.", metavar="ADDRESS")]
_Port = Annotated[int, Option("--port", help="Their port.")]


def receive(
    group: _Group = MULTICAST_GROUP, port: _Port = MULTICAST_PORT, as_json: AsJson = False
) -> None:
    """Receive a single UDP multicast datagram."""
    with open_receiver(group, port) as receiver:
        if not as_json:
            console.out("Waiting for UDP multicast datagram...")
            console.flush()
        text, host, sender_port = receive_datagram(receiver)
    said = f"Received from {host}:{sender_port}: '{text}'"
    console.out_done(said, as_json=as_json, host=host, port=sender_port, text=text)


def send(
    group: _Group = MULTICAST_GROUP,
    port: _Port = MULTICAST_PORT,
    ttl: Annotated[
        int | None,
        Option("--ttl", help="Number of routers that the datagram may pass.", metavar="N"),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Send a UDP multicast datagram with the text ``Hello World!``."""
    if ttl is not None and not 0 < ttl < 256:
        raise UsageError(f"--ttl is 1 to 255, not {ttl}")
    if not as_json:
        console.out("Sending one UDP multicast datagram...")
        console.flush()
    send_datagram(_GREETING.encode(), group, port, ttl)
    if as_json:
        console.out_json({"group": group, "port": port, "text": _GREETING})
