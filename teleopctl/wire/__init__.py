"""Zenoh transport in the wire format of rmw_zenoh: sessions, router, keys, tokens and graph.

May import `interfaces`, and what every package may: `base`, `errors`, `packages` and `plugins`.
"""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.wire.address import RouterAddress as RouterAddress
    from teleopctl.wire.attachment import (
        Attachment as Attachment,
        decode_attachment as decode_attachment,
        encode_attachment as encode_attachment,
    )
    from teleopctl.wire.callbacks import direct_callback as direct_callback
    from teleopctl.wire.config import (
        has_room_for_shared_memory as has_room_for_shared_memory,
        session_config as session_config,
    )
    from teleopctl.wire.connections import is_frozen as is_frozen, session_ports as session_ports
    from teleopctl.wire.graph import (
        Graph as Graph,
        NodeEntry as NodeEntry,
        action_type as action_type,
        actions_of as actions_of,
        is_hidden_name as is_hidden_name,
        query_endpoints as query_endpoints,
        query_graph as query_graph,
    )
    from teleopctl.wire.graph_watcher import GraphWatcher as GraphWatcher
    from teleopctl.wire.invalid_messages import InvalidMessageCounter as InvalidMessageCounter
    from teleopctl.wire.keys import assertion_key as assertion_key, topic_key as topic_key
    from teleopctl.wire.peer_discovery import (
        flush_to_router as flush_to_router,
        wait_for_peer_tokens as wait_for_peer_tokens,
    )
    from teleopctl.wire.qos import (
        INFINITE_NS as INFINITE_NS,
        RELIABILITY_BEST_EFFORT as RELIABILITY_BEST_EFFORT,
        RELIABILITY_RELIABLE as RELIABILITY_RELIABLE,
        EndpointQos as EndpointQos,
    )
    from teleopctl.wire.reach import (
        HOW_TO_CLOSE as HOW_TO_CLOSE,
        RouterReach as RouterReach,
        router_reach as router_reach,
    )
    from teleopctl.wire.requests import (
        ServiceRequest as ServiceRequest,
        no_response_text as no_response_text,
        read_response as read_response,
        responses_of_nodes as responses_of_nodes,
        send_request as send_request,
    )
    from teleopctl.wire.router import (
        daemon_address as daemon_address,
        ensure_router as ensure_router,
        find_router as find_router,
        port_holder as port_holder,
        router_is_running as router_is_running,
        run_daemon as run_daemon,
        start_router as start_router,
        stop_router as stop_router,
    )
    from teleopctl.wire.session import (
        RouterNotRunning as RouterNotRunning,
        close_session as close_session,
        domain_id as domain_id,
        open_session as open_session,
    )
    from teleopctl.wire.time_limits import TIME_LIMITS as TIME_LIMITS
    from teleopctl.wire.tokens import (
        EndpointToken as EndpointToken,
        EntityKind as EntityKind,
        NodeToken as NodeToken,
        format_token as format_token,
        gid as gid,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
