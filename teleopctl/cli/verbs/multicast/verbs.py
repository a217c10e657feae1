"""``teleopctl multicast receive|send``."""

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.multicast import datagrams
from teleopctl.errors import UsageError

_GREETING = "Hello World!"

_Group = Annotated[str, Option("--group", help="The group of receivers.", metavar="ADDRESS")]
_Port = Annotated[int, Option("--port", help="Their port.")]


def receive(
    group: _Group = datagrams.GROUP, port: _Port = datagrams.PORT, as_json: AsJson = False
) -> None:
    """Receive a single UDP multicast datagram."""
    with datagrams.receiver(group, port) as heard:
        if not as_json:
            console.out("Waiting for UDP multicast datagram...")
            console.flush()
        text, host, sender_port = datagrams.receive(heard)
    said = f"Received from {host}:{sender_port}: '{text}'"
    console.out_done(said, as_json=as_json, host=host, port=sender_port, text=text)


def send(
    group: _Group = datagrams.GROUP,
    port: _Port = datagrams.PORT,
    ttl: Annotated[
        int | None, Option("--ttl", help="How many routers it may pass.", metavar="N")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Send a single UDP multicast datagram."""
    if ttl is not None and not 0 < ttl < 256:
        raise UsageError(f"--ttl is 1 to 255, not {ttl}")
    if not as_json:
        console.out("Sending one UDP multicast datagram...")
        console.flush()
    datagrams.send(_GREETING.encode(), group, port, ttl)
    if as_json:
        console.out_json({"group": group, "port": port, "text": _GREETING})
