"""Parameters of the Foxglove bridge, with the names and defaults of ROS 2's foxglove_bridge."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.base.access import FILE_ORIGIN, is_loopback, parse_origin
from teleopctl.base.token_file import default_token_file
from teleopctl.errors import InvalidParameterError
from teleopctl.interfaces import get_message
from teleopctl.node import Node

if TYPE_CHECKING:
    import ssl
    from collections.abc import Sequence

    from foxglove.websocket import Capability

DEFAULT_PORT = 8765
_ALL_CAPABILITIES = (
    "clientPublish",
    "parameters",
    "parametersSubscribe",
    "services",
    "connectionGraph",
    "assets",
)
_TIME = "time"
_ASSETS = (
    r"^package://(?:[-\w%]+/)*[-\w%.]+"
    r"\.(?:dae|fbx|glb|gltf|jpeg|jpg|mtl|obj|png|stl|tif|tiff|urdf|webp|xacro)$"
)
_ANY = [".*"]
_NONE = ["(?!)"]
_HIGHEST_PORT = 65_535
# Foxglove's web app, and its desktop app, whose pages are files of Electron.
_ORIGINS = ("https://app.foxglove.dev", FILE_ORIGIN)


class BridgeSettings:
    """Values of the Foxglove bridge's parameters, read once at the start.

    Args:
        node: Node that declares the parameters.

    Raises:
        InvalidParameterError: The value of a parameter is invalid.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.address = str(self._declare("address", "127.0.0.1", "Host address to listen on"))
        self.port = self._integer("port", DEFAULT_PORT, "TCP port to listen on, 0 for any free one")
        if self.port > _HIGHEST_PORT:
            raise InvalidParameterError(f"port {self.port} is higher than {_HIGHEST_PORT}")
        self.origins = self._origins()
        self.token_file = self._token_file()
        self.topics = self._patterns("topic_whitelist", _ANY, "Topics that clients see")
        self.services = self._patterns("service_whitelist", _ANY, "Services that clients see")
        self.parameters = self._patterns(
            "param_whitelist", _ANY, "Parameters that clients see, as /node.name"
        )
        self.client_topics = self._patterns(
            "client_topic_whitelist", _ANY, "Topics that clients may publish"
        )
        self.best_effort_topics = self._patterns(
            "best_effort_qos_topic_whitelist",
            _NONE,
            "Topics to subscribe to with best effort always",
        )
        self.assets = self._patterns(
            "asset_uri_allowlist", [_ASSETS], "URIs of files that clients may fetch"
        )
        self.capability_names = self._capability_names()
        self.min_depth = self._integer("min_qos_depth", 1, "Smallest queue depth of a topic")
        self.max_depth = self._integer("max_qos_depth", 25, "Largest queue depth of a topic")
        self.includes_hidden = bool(
            self._declare("include_hidden", False, "Include hidden topics and services")
        )
        self.ignores_unresponsive = bool(
            self._declare(
                "ignore_unresponsive_param_nodes",
                True,
                "Stop requesting parameters from a node that has not answered",
            )
        )
        self.backlog = self._integer(
            "message_backlog_size", 1024, "Queue length of a client; the oldest message is dropped"
        )
        self.tls = self._tls()

    @property
    def capabilities(self) -> list[Capability]:
        """Capabilities that the server announces to Foxglove clients; the SDK adds ``assets``."""
        from foxglove.websocket import Capability

        # The SDK adds `assets` itself when the server has an asset handler.
        by_name = {
            "clientPublish": Capability.ClientPublish,
            "connectionGraph": Capability.ConnectionGraph,
            "parameters": Capability.Parameters,
            "parametersSubscribe": Capability.Parameters,
            "services": Capability.Services,
            _TIME: Capability.Time,
        }
        found: list[Capability] = []
        for name in self.capability_names:
            capability = by_name.get(name)
            if capability is not None and capability not in found:
                found.append(capability)
        return found

    @property
    def follows_simulated_time(self) -> bool:
        """Whether the server sends the time of ``/clock`` to Foxglove clients."""
        return _TIME in self.capability_names

    def _capability_names(self) -> list[str]:
        names = [
            str(name)
            for name in self._declare(
                "capabilities", list(_ALL_CAPABILITIES), "What clients may do"
            )
        ]
        unknown = set(names) - {*_ALL_CAPABILITIES, _TIME}
        if unknown:
            raise InvalidParameterError(
                f"Parameter 'capabilities' has {', '.join(sorted(unknown))}",
                hint=f"There are {', '.join((*_ALL_CAPABILITIES, _TIME))}.",
            )
        if self._node.get_parameter("use_sim_time").value and _TIME not in names:
            names.append(_TIME)
        return names

    def _origins(self) -> list[str]:
        texts = [
            str(text)
            for text in self._declare(
                "allowed_origins",
                list(_ORIGINS),
                "Origins whose pages may connect; file:// is Foxglove's desktop app",
            )
        ]
        try:
            return [parse_origin(text) for text in texts]
        except ValueError as error:
            raise InvalidParameterError(
                f"Parameter 'allowed_origins': {error}",
                hint="An origin looks like https://foxglove.example.org, as the browser sends it.",
            ) from error

    def _token_file(self) -> Path | None:
        """Return the file of the access token; None on loopback, where no token is required."""
        named = str(
            self._declare("token_file", "", "File of the access token that clients must present")
        )
        if named:
            return Path(named).expanduser().absolute()
        return None if is_loopback(self.address) else default_token_file()

    def _tls(self) -> ssl.SSLContext | None:
        is_secure = self._declare("tls", False, "Whether connections are encrypted")
        certificate, key = (
            str(self._declare(name, "", description))
            for name, description in (
                ("certfile", "File of the certificate, in PEM"),
                ("keyfile", "File of its private key, in PEM"),
            )
        )
        if not is_secure:
            return None
        import ssl

        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        try:
            for file in (certificate, key):
                Path(file).read_bytes()
            context.load_cert_chain(certificate, key)
        except ssl.SSLError as error:
            raise InvalidParameterError(
                f"'{certificate}' and '{key}' are not a certificate and its key: {error.reason}"
            ) from error
        except OSError as error:
            raise InvalidParameterError(
                f"With tls, certfile and keyfile name the two files: {error.strerror}: "
                f"'{error.filename}'"
            ) from error
        return context

    def _declare(self, name: str, default: Any, description: str) -> Any:
        descriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")
        return self._node.declare_parameter(
            name, default, descriptor(description=description, read_only=True)
        ).value

    def _integer(self, name: str, default: int, description: str) -> int:
        value = int(self._declare(name, default, description))
        if value < 0:
            raise InvalidParameterError(f"Parameter '{name}' is {value}; it must not be negative")
        return value

    def _patterns(self, name: str, default: list[str], description: str) -> list[re.Pattern[str]]:
        try:
            return [
                re.compile(text, re.IGNORECASE)
                for text in self._declare(name, default, description)
            ]
        except re.error as error:
            raise InvalidParameterError(
                f"Parameter '{name}': '{error.pattern!s}' is not a regular expression: {error}"
            ) from error


def allows(patterns: Sequence[re.Pattern[str]], name: str) -> bool:
    """Return whether a whole name matches at least one of several regular expressions."""
    return any(pattern.fullmatch(name) for pattern in patterns)
