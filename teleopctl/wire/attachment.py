"""The 33 bytes that rmw_zenoh attaches to every sample, request and reply.

An attachment contains the number of the message (per publisher or client, from 1 without gaps), its
source time and the GID of its sender. Receivers in C++ throw on a malformed attachment, so only
`encode_attachment` may produce attachments.
"""

from __future__ import annotations

import struct

from teleopctl.base.typed import NamedTuple

GID_SIZE = 16
"""Number of bytes of an endpoint's GID."""

_LAYOUT = struct.Struct("<qqB16s")
_LEGACY_SIZE = 77
_LEGACY_FIRST_BYTE = 0x0F


class Attachment(NamedTuple):
    """Attachment of a message: sequence number, source time and GID of its sender."""

    sequence: int
    time_ns: int
    gid: bytes


def encode_attachment(sequence: int, time_ns: int, gid: bytes) -> bytes:
    """Return an attachment as bytes, in the layout of rmw_zenoh.

    Args:
        sequence: Number of the message; a reply repeats that of its request.
        time_ns: Source time, in nanoseconds since the Unix epoch.
        gid: GID of the sender, 16 bytes; a reply repeats that of its request.

    Raises:
        ValueError: The GID does not have 16 bytes.
    """
    if len(gid) != GID_SIZE:
        raise ValueError(f"a GID has {GID_SIZE} bytes, not {len(gid)}")
    return _LAYOUT.pack(sequence, time_ns, GID_SIZE, gid)


def decode_attachment(data: bytes) -> Attachment | None:
    """Return the attachment that bytes encode; None if the bytes are not an attachment."""
    if len(data) != _LAYOUT.size:
        return None
    sequence, time_ns, gid_size, gid = _LAYOUT.unpack(data)
    return Attachment(sequence, time_ns, gid) if gid_size == GID_SIZE else None


def is_legacy(data: bytes) -> bool:
    """Return whether bytes are an attachment of rmw_zenoh from before April 2025, unsupported."""
    return len(data) == _LEGACY_SIZE and data[0] == _LEGACY_FIRST_BYTE
