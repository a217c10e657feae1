"""What a script does with Zenoh alone: the floor of what ours do on the command line.

``python bare_commands.py tokens`` | ``ask KEY`` | ``first KEY`` | ``put KEY``. Nothing is decoded
or looked up: who writes such a script knows the key with its type and hash.
"""

import os
import sys

import zenoh

ATTACHMENT = bytes(8) + bytes(8) + bytes([16]) + bytes(16)
NOTHING = bytes((0, 1, 0, 0, 0, 0, 0, 0))  # an empty sequence, or an empty request's byte

router = os.environ["TELEOPCTL_ROUTER"]
config = zenoh.Config.from_json5(
    f"""{{
  mode: "client",
  connect: {{ endpoints: ["{router}"] }},
  scouting: {{ multicast: {{ enabled: false }} }},
}}"""
)
with zenoh.open(config) as session:
    match sys.argv[1:]:
        case ["tokens"]:
            everything = f"@ros2_lv/{os.environ['ROS_DOMAIN_ID']}/**"
            for reply in session.liveliness().get(everything):
                assert reply.ok is not None
                print(reply.ok.key_expr)
        case ["ask", key]:
            for reply in session.get(key, payload=NOTHING, attachment=ATTACHMENT):
                assert reply.ok is not None
                print(reply.ok.payload.to_bytes())
                break
        case ["first", key]:
            print(session.declare_subscriber(key).recv().payload.to_bytes())
        case ["put", key]:
            session.put(key, NOTHING, attachment=ATTACHMENT)
