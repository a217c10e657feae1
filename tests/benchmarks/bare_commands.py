"""Commands that use Zenoh alone: the floor of teleopctl's commands.

``python bare_commands.py tokens`` | ``parameter NODE NAME`` | ``set NODE NAME INTEGER`` |
``trigger SERVICE`` | ``controllers SERVICE`` | ``first TOPIC`` | ``put TOPIC TEXT``. Like
teleopctl's commands, each discovers the other endpoint in the graph, reads type and hash from that
endpoint's token, and waits for the response. Data is packed and unpacked by hand, for one type. The
commands declare no tokens of their own.
"""

import os
import struct
import sys
import time

import zenoh

NOTHING = bytes(1)  # CDR of a request without fields
HEADER = bytes((0, 1, 0, 0))  # of CDR, little-endian


def key_of(session: zenoh.Session, kind: str, name: str) -> str:
    """Return the key of the first server, publisher or subscription of a name, or exit."""
    domain, mangled = os.environ["ROS_DOMAIN_ID"], name.replace("/", "%")
    tokens = f"@ros2_lv/{domain}/*/*/*/{kind}/*/*/*/{mangled}/**"
    for reply in session.liveliness().get(tokens):
        assert reply.ok is not None
        *_, type_name, type_hash, _ = str(reply.ok.key_expr).split("/")
        return f"{domain}{name}/{type_name}/{type_hash}"
    sys.exit(f"nobody has {name}")


def attachment() -> bytes:
    return struct.pack("<qqB16s", 1, time.time_ns(), 16, bytes(16))


def ask(session: zenoh.Session, service: str, request: bytes) -> bytes:
    key = key_of(session, "SS", service)
    for reply in session.get(key, payload=HEADER + request, attachment=attachment()):
        assert reply.ok is not None
        return reply.ok.payload.to_bytes()
    sys.exit("no answer")


def packed(text: str) -> bytes:
    return struct.pack(f"<I{len(text) + 1}s", len(text) + 1, text.encode())


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
        case ["parameter", node, name]:
            values = ask(session, f"{node}/get_parameters", struct.pack("<I", 1) + packed(name))
            print("Integer value is:", *struct.unpack_from("<q", values, len(HEADER) + 8))
        case ["set", node, name, value]:
            # ParameterValue: type, bool, integer, double, string and five empty arrays.
            name_and_type = struct.pack("<I", 1) + packed(name)
            fields = name_and_type + struct.pack("<BB", 2, 0)
            fields += bytes(-len(fields) % 8) + struct.pack("<qd", int(value), 0.0)
            fields += packed("") + bytes(3) + struct.pack("<5I", *[0] * 5)
            results = ask(session, f"{node}/set_parameters", fields)
            print("Set parameter", *struct.unpack_from("<I?", results, len(HEADER)))
        case ["controllers", service]:
            response = ask(session, service, NOTHING)
            (count,) = struct.unpack_from("<I", response, len(HEADER))
            length, at = *struct.unpack_from("<I", response, len(HEADER) + 4), len(HEADER) + 8
            print(count, "controllers, the first is", response[at : at + length - 1].decode())
        case ["trigger", service]:
            response = ask(session, service, NOTHING)
            print("success:", *struct.unpack_from("<?", response, len(HEADER)))
        case ["first", topic]:
            subscriber = session.declare_subscriber(key_of(session, "MP", topic))
            message = subscriber.recv().payload.to_bytes()
            print("data:", message[len(HEADER) + 4 : -1].decode())
        case ["put", topic, text]:
            key = key_of(session, "MS", topic)
            print("publishing:", text)
            session.put(key, HEADER + packed(text), attachment=attachment())
