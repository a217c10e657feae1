"""``teleopctl multicast``."""

from __future__ import annotations

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "Send and receive datagrams to many machines.",
    {
        "receive": Verb(f"{__name__}.verbs:receive", "Receive a single datagram."),
        "send": Verb(f"{__name__}.verbs:send", "Send a single datagram."),
    },
)
