"""Check of the clocks of the machines in the graph.

A reply tells when it was sent. By the rule of NTP that was in the middle between question and
answer, give or take half of what they took: https://www.rfc-editor.org/rfc/rfc5905#section-8
"""

from __future__ import annotations

import time
from collections.abc import Iterator

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli.verbs.doctor.finding import Finding
from teleopctl.cli.verbs.doctor.graph import sessions
from teleopctl.interfaces import get_service, serialize
from teleopctl.wire import (
    EndpointToken,
    Graph,
    decode_attachment,
    encode_attachment,
    open_session,
    topic_key,
)

if TYPE_CHECKING:
    import zenoh

_ANSWER_WITHIN_S = 1.0
# What tf takes for the future or for too old, where nodes ask for "now".
_LARGEST_OFFSET_NS = 10_000_000
_NOBODY = bytes(16)


def check_clocks(graph: Graph) -> Iterator[Finding]:
    """Yield machines whose clocks differ from this one's."""
    with open_session("client") as session:
        for server in sessions(graph).values():
            measured = _offset_ns(session, server)
            if measured is not None and abs(measured[0]) > _LARGEST_OFFSET_NS + measured[1]:
                ahead = "ahead of" if measured[0] > 0 else "behind"
                yield Finding(
                    f"The clock of {server.full_name} is {abs(measured[0]) / 1e9:.3f} s {ahead} "
                    "this machine's: its transforms and stamps are taken for old or of the future.",
                    "Synchronise the machines, with chrony for one.",
                )


def _offset_ns(session: zenoh.Session, server: EndpointToken) -> tuple[int, int] | None:
    """Return how far a clock is ahead of this one, and by how much that may be wrong."""
    request = get_service(server.type_name).Request()
    key = topic_key(server.domain, server.name, server.type_name, server.type_hash)
    asked_ns = time.time_ns()
    replies = session.get(
        key,
        payload=serialize(request),
        attachment=encode_attachment(1, asked_ns, _NOBODY),
        timeout=_ANSWER_WITHIN_S,
    )
    for reply in replies:
        answered_ns = time.time_ns()
        if reply.ok is None or reply.ok.attachment is None:
            continue
        told = decode_attachment(reply.ok.attachment.to_bytes())
        if told is not None:
            middle_ns = (asked_ns + answered_ns) // 2
            return told.time_ns - middle_ns, (answered_ns - asked_ns) // 2
    return None
