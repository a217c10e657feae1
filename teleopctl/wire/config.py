"""Zenoh configuration of sessions and of the router, compatible with that of rmw_zenoh.

Environment variables are read as in rmw_zenoh: ``ZENOH_SESSION_CONFIG_URI`` and
``ZENOH_ROUTER_CONFIG_URI`` name a file that replaces the built-in configuration, and
``ZENOH_CONFIG_OVERRIDE`` (``key=json5;key=json5``) has the highest priority. ``TELEOPCTL_ROUTER``
(``tcp/host:port``), which rmw_zenoh lacks, sets the router's address. Each configuration is
returned with the resulting address of the router.
"""

from __future__ import annotations

import os

import zenoh

from teleopctl.base.typed import TYPE_CHECKING, Literal, Sequence
from teleopctl.errors import UsageError
from teleopctl.wire.address import DEFAULT_ADDRESS, RouterAddress

if TYPE_CHECKING:
    SessionMode = Literal["peer", "client"]

_SESSION_FILE = "ZENOH_SESSION_CONFIG_URI"
_ROUTER_FILE = "ZENOH_ROUTER_CONFIG_URI"
_ROUTER = "TELEOPCTL_ROUTER"
_OVERRIDE = "ZENOH_CONFIG_OVERRIDE"

# One text, parsed once, is several times faster than setting key by key. Times in milliseconds,
# in the transmission queue in microseconds.
#
# The queue's size and its wait for fragments are not rmw_zenoh's 2 and 50000. A large message is
# sent in fragments of 64 kB and dropped if a fragment finds no room in time, which on a busy
# machine happened to one in six messages of 9 MB. The wait doubles from a millisecond with each
# fragment, so that room for eight also makes the first wait long enough.
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
        queue: {
          size: { data: 8 },
          congestion_control: {
            drop: { max_wait_before_drop_fragments: 500000 },
            block: { wait_before_close: %(wait_before_close)s },
          },
        },
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

# rmw_zenoh's period grows to four seconds, for which nodes would be invisible after a restart of
# the router. On loopback an attempt takes a tenth of a millisecond.
_RETRY = "{ period_init_ms: 250, period_max_ms: 1000, period_increase_factor: 2 }"

# No scouting delay: Zenoh's own wait for the first connections misses some and then always lasts
# half a second; `peer_discovery` waits for connection events instead.
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
  connect: { endpoints: %(connect)s, timeout_ms: 0, exit_on_failure: true, retry: %(retry)s },"""
    + _COMMON
    + "}"
)
_ROUTER_TEMPLATE = (
    """{ mode: "router",
  connect: { endpoints: [], timeout_ms: -1, exit_on_failure: false, retry: %(retry)s },
  listen: { endpoints: %(listen)s, timeout_ms: 0, exit_on_failure: true },
  adminspace: { enabled: true, permissions: { read: true, write: false } },"""
    + _COMMON
    + "}"
)


class SessionConfig:
    """Zenoh configuration of a session, with its mode and the router that it looks for.

    Attributes:
        zenoh: The configuration as a Zenoh object.
        mode: ``peer`` or ``client``, after all settings of the environment.
        router: Address at which the session looks for a router.
    """

    __slots__ = ("mode", "router", "zenoh")

    def __init__(self, config: zenoh.Config, mode: str, router: RouterAddress) -> None:
        self.zenoh = config
        self.mode = mode
        self.router = router


class RouterConfig:
    """Zenoh configuration of a router, with the address at which it listens.

    Attributes:
        zenoh: The configuration as a Zenoh object.
        address: Address at which the router listens.
        is_stated: Whether the address follows from that of the sessions. False if the router's
            configuration file or an override sets it.
    """

    __slots__ = ("address", "is_stated", "zenoh")

    def __init__(self, config: zenoh.Config, address: RouterAddress, *, is_stated: bool) -> None:
        self.zenoh = config
        self.address = address
        self.is_stated = is_stated


def zenoh_error_text(error: zenoh.ZError) -> str:
    """Return the message of a Zenoh error, without places in Zenoh's source code."""
    import re

    text = re.sub(r" at \S+\.rs:\d+\.?", "", str(error)).strip()
    quoted = re.search(r'(?:Str\(|msg: )"(.*?)"(?:\)|, location)', text)
    # The JSON5 parser draws the place of an error, and names the expected tokens in the last line.
    return quoted[1].split("\\n")[-1].strip(" =") if quoted else text


def session_config(mode: SessionMode) -> SessionConfig:
    """Return the configuration of a session, as environment variables and files set it.

    Args:
        mode: Mode of the session, unless the environment sets another one.

    Raises:
        UsageError: A file, an endpoint or an override cannot be used.
    """
    path = os.environ.get(_SESSION_FILE)
    router = _stated_router()
    if path:
        config = _from_file(path, _SESSION_FILE)
        if router.origin == _ROUTER:
            config.insert_json5("connect/endpoints", _json_list(router.endpoints))
        if mode == "client" and router.endpoints:
            config.insert_json5("mode", '"client"')
    else:
        if not router.is_on_this_machine:
            # A router does not forward between two peers, and other machines cannot connect to a
            # peer that listens on loopback. A client reaches all processes through the router.
            mode = "client"
        config = _from_text(
            _CLIENT if mode == "client" else _PEER,
            router,
            connect=_json_list(router.endpoints),
            # Detects a program that accepts the connection and sends nothing.
            open_timeout="3000" if mode == "client" else "60000",
            to_peer="greater-zid",
            # Unlike in rmw_zenoh: images are transferred in a quarter of the time. It is negotiated
            # for each connection, so a ROS process without it still receives the bytes.
            shared_memory="true" if mode == "peer" and has_room_for_shared_memory() else "false",
            wait_before_close="60000000",
        )
    if "connect" in _override(config):
        router = RouterAddress(_endpoints(config, "connect"), _OVERRIDE)
    _check(router)
    return SessionConfig(config, _mode_of(config), router)


def probe_config(address: RouterAddress) -> SessionConfig:
    """Return the configuration of a client that connects only to the router at an address.

    Raises:
        UsageError: A file, an endpoint or an override cannot be used.
    """
    config = session_config("client").zenoh
    address = address.to_connect()
    for key, value in (
        ("mode", '"client"'),
        ("connect/endpoints", _json_list(address.endpoints)),
        ("connect/timeout_ms", "0"),
        ("connect/exit_on_failure", "true"),
        # An override for the router would make the probe listen on the router's own port.
        ("listen/endpoints", "[]"),
    ):
        config.insert_json5(key, value)
    return SessionConfig(config, "client", address)


def router_config(listen: Sequence[str] = ()) -> RouterConfig:
    """Return the configuration of a router, as environment variables and files set it.

    The router listens at the address where sessions look for it, unless a file or an override sets
    another one. ``connect/endpoints`` of an override is not that address: in a router's
    configuration it names other routers.

    Args:
        listen: Endpoints to listen on instead, unless a file or an override sets them.

    Raises:
        UsageError: A file, an endpoint or an override cannot be used, or sets another mode.
    """
    path = os.environ.get(_ROUTER_FILE)
    if path:
        config = _from_file(path, _ROUTER_FILE)
        address = RouterAddress(_endpoints(config, "listen"), path)
    else:
        address = _stated_router()
        # Without endpoints sessions find routers by multicast.
        address = address if address.endpoints else DEFAULT_ADDRESS
        if listen:
            address = RouterAddress(tuple(listen), address.origin)
        config = _from_text(
            _ROUTER_TEMPLATE,
            address,
            listen=_json_list([each for text in address.endpoints for each in _loopbacks(text)]),
            open_timeout="60000",
            to_peer="always",
            shared_memory="false",
            wait_before_close="5000000",
        )
    overridden = _override(config)
    if "listen" in overridden:
        address = RouterAddress(_endpoints(config, "listen"), _OVERRIDE)
    if _mode_of(config) != "router":
        origin = _OVERRIDE if "mode" in overridden else path
        raise UsageError(
            f"A router cannot start in the mode {_mode_of(config)!r}, which {origin} sets.",
            hint=f"{origin} may be meant for sessions only: start the daemon without it.",
        )
    _check(address)
    is_stated = not path and "listen" not in overridden
    return RouterConfig(config, address, is_stated=is_stated)


def start_hint(router: RouterAddress) -> str:
    """Return a hint for the user on how to start a router at an address where none answers."""
    try:
        daemon = router_config().address
    except UsageError as error:
        hint = f" {error.hint}" if error.hint else ""
        return f"'teleopctl daemon start' cannot start one: {error.message.rstrip('.')}.{hint}"
    if not router.endpoints:
        return (
            f"Set the router's address in connect/endpoints of {router.origin}: 'teleopctl daemon "
            f"start' starts one at {daemon}."
        )
    if daemon.serves(router) and router.is_on_this_machine:
        return "Start one with 'teleopctl daemon start'."
    correct = f", or correct {router.origin}" if router.origin else ""
    if daemon.serves(router):
        return f"Start one on that machine with 'teleopctl daemon start'{correct}."
    return f"Start one there{correct} ('teleopctl daemon start' starts one at {daemon})."


def _check(address: RouterAddress) -> None:
    if address.fault is not None:
        raise UsageError(
            f"No router can listen at {address}: {address.fault}.",
            hint="An endpoint has the form tcp/host:port.",
        )


def _stated_router() -> RouterAddress:
    """Address at which sessions look for a router, without overrides."""
    chosen = os.environ.get(_ROUTER)
    if chosen:
        return RouterAddress((chosen,), _ROUTER)
    path = os.environ.get(_SESSION_FILE)
    if path:
        return RouterAddress(_endpoints(_from_file(path, _SESSION_FILE), "connect"), path)
    return DEFAULT_ADDRESS


def _endpoints(config: zenoh.Config, side: Literal["connect", "listen"]) -> tuple[str, ...]:
    """Endpoints of one side, which Zenoh stores as one list or as one for each mode."""
    import json

    value = json.loads(config.get_json(f"{side}/endpoints"))
    if isinstance(value, dict):
        value = value.get(_mode_of(config), ())
    return tuple(str(endpoint) for endpoint in value)


def _loopbacks(endpoint: str) -> Sequence[str]:
    """Both loopback addresses for ``localhost``, since a client may try either first."""
    protocol, slash, address = endpoint.partition("/")
    host, colon, port = address.rpartition(":")
    if not slash or not colon or host != "localhost":
        return [endpoint]
    return [f"{protocol}/127.0.0.1:{port}", f"{protocol}/[::1]:{port}#exit_on_failure=false"]


def has_room_for_shared_memory() -> bool:
    """Return whether ``/dev/shm`` has at least 512 MiB free; True on systems without it.

    Containers often have 64 MiB, little more than one pool. Systems without ``/dev/shm`` have no
    limit of that kind.
    """
    try:
        room = os.statvfs(_SHARED_MEMORY_FOLDER)
    except (OSError, AttributeError):
        return True
    return room.f_bavail * room.f_frsize >= _ROOM_FOR_SHARED_MEMORY


def _mode_of(config: zenoh.Config) -> str:
    """``peer``, ``client`` or ``router``."""
    return str(config.get_json("mode")).strip('"')


def _from_text(template: str, address: RouterAddress, **values: str) -> zenoh.Config:
    text = template % {"retry": _RETRY, "scouting_delay": "delay: 0,", **values}
    try:
        return zenoh.Config.from_json5(text)
    except zenoh.ZError as error:
        raise UsageError(
            f"Zenoh does not accept the endpoint {address}: {zenoh_error_text(error)}",
            hint="An endpoint has the form tcp/host:port.",
        ) from error


def _from_file(path: str, variable: str) -> zenoh.Config:
    try:
        return zenoh.Config.from_file(path.removeprefix("file://"))
    except zenoh.ZError as error:
        raise UsageError(
            f"The Zenoh configuration {path} named by {variable} cannot be used: "
            f"{zenoh_error_text(error)}",
        ) from error


def _override(config: zenoh.Config) -> set[str]:
    """Apply the overrides; return the sections of the configuration that they change."""
    sections = set()
    for assignment in os.environ.get(_OVERRIDE, "").split(";"):
        if not assignment.strip():
            continue
        key, equals, value = assignment.partition("=")
        fault = None if equals else "there is no '=' in it"
        if fault is None:
            try:
                config.insert_json5(key.strip(), value.strip())
            except zenoh.ZError as error:
                fault = zenoh_error_text(error)
        if fault is not None:
            raise UsageError(
                f"A part of {_OVERRIDE} cannot be used, {assignment!r}: {fault}",
                hint="Its form is key=value;key=value, the values in JSON5.",
            )
        sections.add(key.strip().partition("/")[0])
    return sections


def _json_list(texts: Sequence[str]) -> str:
    # JSON5 has Python's escapes for all characters of endpoints; json is slow to import.
    return f"[{', '.join(repr(text) for text in texts)}]"
