"""Process with a node's token in a session of an older Zenoh: ``old_peer PORT DOMAIN``.

The session is configured like those of rmw_zenoh.
"""

import sys

import zenoh

port, domain = sys.argv[1], sys.argv[2]
config = zenoh.Config.from_json5(
    f"""{{ mode: "peer",
      connect: {{ endpoints: ["tcp/127.0.0.1:{port}"], timeout_ms: -1, exit_on_failure: false,
                 retry: {{ period_init_ms: 100, period_max_ms: 100 }} }},
      listen: {{ endpoints: ["tcp/127.0.0.1:0"] }},
      scouting: {{ multicast: {{ enabled: false }}, gossip: {{ enabled: true }} }},
    }}"""
)
with zenoh.open(config) as session:
    token = f"@ros2_lv/{domain}/{session.zid()}/0/0/NN/%/%/old_node"
    held = session.liveliness().declare_token(token)
    print("up", flush=True)
    sys.stdin.read()
