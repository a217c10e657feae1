"""Endpoints of topics and services, as ``info`` prints them."""

from __future__ import annotations

from collections.abc import Sequence

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli import console
from teleopctl.cli.verbs.topic.qos.text import qos_lines, qos_record

if TYPE_CHECKING:
    from teleopctl.wire import EndpointToken


def endpoint_block(endpoint: EndpointToken, kind: str, role: str) -> list[str]:
    """Return the lines of an endpoint in ``info --verbose``.

    Args:
        endpoint: The endpoint.
        kind: What it belongs to: ``Topic`` or ``Service``.
        role: Such as ``PUBLISHER``.
    """
    return [
        f"Node name: {endpoint.node}",
        f"Node namespace: {endpoint.namespace}",
        f"{kind} type: {endpoint.type_name}",
        f"{kind} type hash: {endpoint.type_hash}",
        f"Endpoint type: {role}",
        f"GID: {endpoint.gid.hex('.')}",
        *qos_lines(endpoint.qos),
        "",
    ]


def endpoint_record(endpoint: EndpointToken) -> dict[str, console.Json]:
    """Return an endpoint's properties for ``--json``."""
    return {
        "node": endpoint.node,
        "namespace": endpoint.namespace,
        "type": endpoint.type_name,
        "type_hash": endpoint.type_hash,
        "gid": endpoint.gid.hex(),
        "qos": qos_record(endpoint.qos),
    }


def warn_of_mismatch(topic: str, endpoints: Sequence[EndpointToken]) -> None:
    """Warn of endpoints with different types or type hashes, which exchange no messages."""
    types = {endpoint.type_name for endpoint in endpoints}
    if len(types) > 1:
        console.warn(
            f"{topic} has more than one type ({', '.join(sorted(types))}); "
            "nothing passes between ends of different types"
        )
    for type_name in sorted(types):
        nodes_by_hash: dict[str, list[str]] = {}
        for endpoint in endpoints:
            if endpoint.type_name == type_name:
                nodes_by_hash.setdefault(endpoint.type_hash, []).append(endpoint.full_name)
        if len(nodes_by_hash) > 1:
            groups = " and ".join(", ".join(sorted(set(nodes))) for nodes in nodes_by_hash.values())
            console.warn(
                f"{topic}: {groups} mean different versions of {type_name} (their type hashes "
                "differ), so nothing passes between them"
            )
