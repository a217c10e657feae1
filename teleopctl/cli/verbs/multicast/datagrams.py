"""Datagrams to many machines at once: UDP multicast, as ``ros2 multicast`` sends it."""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from teleopctl.errors import SystemFailureError, UsageError

GROUP = "225.0.0.1"
PORT = 49150
_LARGEST = 4096


def send(data: bytes, group: str = GROUP, port: int = PORT, ttl: int | None = None) -> None:
    """Send a datagram to a multicast group.

    Args:
        data: What it holds.
        group: The group of receivers, an IPv4 address from 224.0.0.0 to 239.255.255.255.
        port: Their port.
        ttl: How many routers it may pass; by default none.

    Raises:
        SystemFailureError: This machine has no way to send it.
        UsageError: There is no such group, port or number.
    """
    with _checked(group, port), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        if ttl is not None:
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, ttl)
        sender.sendto(data, (group, port))


@contextmanager
def receiver(group: str = GROUP, port: int = PORT) -> Iterator[socket.socket]:
    """Open a socket that receives the datagrams of a multicast group.

    Raises:
        SystemFailureError: This machine cannot listen there.
        UsageError: There is no such group or port.
    """
    with _checked(group, port), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as heard:
        heard.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        with suppress(AttributeError):  # Windows has no such option
            heard.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        heard.bind(("", port))
        membership = struct.pack("=4sL", socket.inet_aton(group), socket.INADDR_ANY)
        heard.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        yield heard


def receive(heard: socket.socket) -> tuple[str, str, int]:
    """Wait for a datagram; return its text and its sender's host and port."""
    data, (host, port) = heard.recvfrom(_LARGEST)
    return data.decode(errors="replace"), host, port


@contextmanager
def _checked(group: str, port: int) -> Iterator[None]:
    try:
        if not 224 <= socket.inet_aton(group)[0] <= 239:
            raise UsageError(f"{group} is no multicast group: those begin with 224 to 239")
        if not 0 < port < 65536:
            raise UsageError(f"{port} is no port: 1 to 65535")
        yield
    except OSError as error:
        if isinstance(error, TimeoutError):
            raise
        raise SystemFailureError(
            f"Cannot use the multicast group {group}, port {port}: {error.strerror or error}"
        ) from error
