"""Zenoh configuration of sessions and of the router, equal to that of rmw_zenoh where it matters.

The environment is honoured as by a ROS process: ``ZENOH_SESSION_CONFIG_URI`` and
``ZENOH_ROUTER_CONFIG_URI`` name a file that replaces the built-in configuration,
``TELEOPCTL_ROUTER`` (``tcp/host:port``) is the short way to say where the router is, and
``ZENOH_CONFIG_OVERRIDE`` (``key=json5;key=json5``) has the last word.
"""

import os
import re
from collections.abc import Sequence
from typing import Literal

import zenoh

from teleopctl.errors import UsageError

SessionMode = Literal["peer", "client"]

DEFAULT_ROUTER = "tcp/localhost:7447"

# One text, parsed once, is several times faster than setting key by key. Times in milliseconds,
# in the transmission queue in microseconds.
_COMMON = """
  scouting: {
    %(scouting_delay)s
    multicast: { enabled: false },
    gossip: {
      enabled: true,
      multihop: false,
      target: { router: ["router", "peer"], peer: ["router"] },
      autoconnect: { router: [], peer: ["router", "peer"] },
      autoconnect_strategy: { peer: { to_router: "always", to_peer: "%(to_peer)s" } },
    },
  },
  timestamping: { enabled: true },
  queries_default_timeout: 600000,
  routing: { interests: { timeout: 10000 } },
  transport: {
    unicast: {
      open_timeout: %(open_timeout)s,
      accept_timeout: 60000,
      accept_pending: 10000,
      max_sessions: 10000,
      max_links: 1,
    },
    link: {
      tx: {
        lease: 60000,
        keep_alive: 2,
        queue: { congestion_control: { block: { wait_before_close: %(wait_before_close)s } } },
      },
    },
    shared_memory: {
      enabled: %(shared_memory)s,
      mode: "lazy",
      transport_optimization: { pool_size: 50331648, message_size_threshold: 65536 },
    },
  },
"""
_SHARED_MEMORY_FOLDER = "/dev/shm"  # noqa: S108 (the kernel's, no file of ours)
_ROOM_FOR_SHARED_MEMORY = 512 * 2**20

_RETRY = "{ period_init_ms: 1000, period_max_ms: 4000, period_increase_factor: 2 }"

# Zenoh's own wait for the first connections misses some and then lasts half a second whatever
# happens; `introduction` waits for the same thing by events.
_PEER = (
    """{ mode: "peer",
  connect: { endpoints: %(connect)s, timeout_ms: -1, exit_on_failure: false, retry: %(retry)s },
  listen: { endpoints: ["tcp/localhost:0"], retry: %(retry)s },
  adminspace: { enabled: true, permissions: { read: true, write: false } },"""
    + _COMMON
    + "}"
)
_CLIENT = (
    """{ mode: "client",
  connect: { endpoints: %(connect)s, timeout_ms: 0, exit_on_failure: true },"""
    + _COMMON
    + "}"
)
_ROUTER = (
    """{ mode: "router",
  connect: { endpoints: [], timeout_ms: -1, exit_on_failure: false, retry: %(retry)s },
  listen: { endpoints: %(listen)s, timeout_ms: 0, exit_on_failure: true },
  adminspace: { enabled: true, permissions: { read: true, write: false } },"""
    + _COMMON
    + "}"
)


_SOURCE_POSITION = re.compile(r" at \S+\.rs:\d+\.?")
_QUOTED_REASON = re.compile(r'(?:Str\(|msg: )"(.*?)"(?:\)|, location)')


def reason_of(error: zenoh.ZError) -> str:
    """What Zenoh says went wrong, without the places in its source code."""
    text = _SOURCE_POSITION.sub("", str(error)).strip()
    quoted = _QUOTED_REASON.search(text)
    # The parser of JSON5 draws where it stopped, and names what it wanted in the last line.
    return quoted[1].split("\\n")[-1].strip(" =") if quoted else text


def router_endpoint() -> str:
    """Where the router is expected: ``TELEOPCTL_ROUTER``, else ``tcp/localhost:7447``."""
    return os.environ.get("TELEOPCTL_ROUTER") or DEFAULT_ROUTER


def session_config(mode: SessionMode) -> zenoh.Config:
    """Return the configuration of a session as the environment wants it.

    Raises:
        TeleopctlError: A file or an override cannot be read.
    """
    path = os.environ.get("ZENOH_SESSION_CONFIG_URI")
    if path:
        config = _from_file(path, "ZENOH_SESSION_CONFIG_URI")
        if "TELEOPCTL_ROUTER" in os.environ:
            config.insert_json5("connect/endpoints", _json_list([router_endpoint()]))
        if mode == "client" and has_endpoints(config):
            config.insert_json5("mode", '"client"')
    else:
        endpoint = router_endpoint()
        if not _is_on_this_machine(endpoint):
            # A router does not forward between two peers, and on another machine nobody could
            # connect to a peer that listens on loopback. A client reaches all through the router.
            mode = "client"
        config = _from_text(
            _CLIENT if mode == "client" else _PEER,
            connect=_json_list([endpoint]),
            # A program that accepts the connection and says nothing is found out by this.
            open_timeout="3000" if mode == "client" else "60000",
            to_peer="greater-zid",
            # Unlike rmw_zenoh's: an image goes over in a quarter of the time. It is agreed upon
            # for each connection, so a ROS process that has it off still gets the bytes.
            shared_memory="true" if mode == "peer" and _has_room_for_shared_memory() else "false",
            wait_before_close="60000000",
        )
    return _override(config)


def _has_room_for_shared_memory() -> bool:
    """Whether pools of several processes fit: where they do not, touching one is a bus error.

    Containers often have 64 MiB, little more than one pool. Systems without that folder set no
    limit of their own.
    """
    try:
        room = os.statvfs(_SHARED_MEMORY_FOLDER)
    except (OSError, AttributeError):
        return True
    return room.f_bavail * room.f_frsize >= _ROOM_FOR_SHARED_MEMORY


def mode_of(config: zenoh.Config) -> str:
    """``peer``, ``client`` or ``router``."""
    return str(config.get_json("mode")).strip('"')


def has_endpoints(config: zenoh.Config) -> bool:
    """Whether a session of this configuration connects to anybody by address."""
    return '"' in config.get_json("connect/endpoints")


def router_config(listen: Sequence[str]) -> zenoh.Config:
    """Return the configuration of a router as the environment wants it.

    Args:
        listen: Endpoints to listen on unless a configuration file says otherwise.

    Raises:
        TeleopctlError: A file or an override cannot be read, or an endpoint is malformed.
    """
    path = os.environ.get("ZENOH_ROUTER_CONFIG_URI")
    if path:
        return _override(_from_file(path, "ZENOH_ROUTER_CONFIG_URI"))
    config = _from_text(
        _ROUTER,
        listen=_json_list(listen),
        open_timeout="60000",
        to_peer="always",
        shared_memory="false",
        wait_before_close="5000000",
    )
    return _override(config)


def _from_text(template: str, **values: str) -> zenoh.Config:
    text = template % {"retry": _RETRY, "scouting_delay": "delay: 0,", **values}
    try:
        return zenoh.Config.from_json5(text)
    except zenoh.ZError as error:
        raise UsageError(
            f"Zenoh does not accept the endpoint {router_endpoint()!r}: {reason_of(error)}",
            hint="TELEOPCTL_ROUTER has the form tcp/host:port.",
        ) from error


def _from_file(path: str, variable: str) -> zenoh.Config:
    try:
        return zenoh.Config.from_file(path.removeprefix("file://"))
    except zenoh.ZError as error:
        raise UsageError(
            f"The Zenoh configuration {path} named by {variable} cannot be used: "
            f"{reason_of(error)}",
        ) from error


def _override(config: zenoh.Config) -> zenoh.Config:
    for assignment in os.environ.get("ZENOH_CONFIG_OVERRIDE", "").split(";"):
        if not assignment.strip():
            continue
        key, equals, value = assignment.partition("=")
        fault = None if equals else "there is no '=' in it"
        if fault is None:
            try:
                config.insert_json5(key.strip(), value.strip())
            except zenoh.ZError as error:
                fault = reason_of(error)
        if fault is not None:
            raise UsageError(
                f"A part of ZENOH_CONFIG_OVERRIDE cannot be used, {assignment!r}: {fault}",
                hint="Its form is key=value;key=value, the values in JSON5.",
            )
    return config


def _is_on_this_machine(endpoint: str) -> bool:
    protocol, _, address = endpoint.partition("/")
    host = address.partition("#")[0].rpartition(":")[0]
    return host in ("localhost", "[::1]") or host.startswith("127.") or protocol.startswith("unix")


def _json_list(texts: Sequence[str]) -> str:
    # JSON5 has Python's escapes for all that can stand in an endpoint; json is slow to import.
    return f"[{', '.join(repr(text) for text in texts)}]"
