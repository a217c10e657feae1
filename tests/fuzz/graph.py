"""Sends hostile inputs to living nodes over the wire, and sees that they live and answer.

``python -m tests.fuzz.graph [--count N] [--seed N]``: to /clock, topics, services and the graph's
tokens of nodes with simulated time; then each has to answer a parameter request.
"""

from __future__ import annotations

import argparse
import contextlib
import random
import subprocess
import sys
import tempfile

import zenoh

from teleopctl.interfaces import get_message, get_service, serialize, type_hash
from teleopctl.node import Context, Node
from teleopctl.wire import encode_attachment, topic_key
from tests.faults.isolation import own_graph
from tests.fuzz.inputs import bytes_of, text_of

_RUN = (sys.executable, "-m", "teleopctl", "run", "teleop_py_pkg")
_NODES = ("simple_subscriber", "simple_parameter")
_TOPICS = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/chatter": "std_msgs/msg/String",
    "/parameter_events": "rcl_interfaces/msg/ParameterEvent",
}
_SERVICE = "rcl_interfaces/srv/GetParameters"
_TOKEN = (
    "@ros2_lv/{domain}/abc123/1/2/MP/%/%/talker/%chatter/std_msgs::msg::dds_::String_/R/::,1:,:,:,,"
)


class Attacker:
    """Sender of random and damaged data through the Zenoh session of a context."""

    def __init__(self, context: Context, chance: random.Random) -> None:
        self._session = context.session
        self._domain = context.domain_id
        self._chance = chance
        self._attachment = encode_attachment(1, 2, bytes(16))
        self._targets = [
            (
                topic_key(self._domain, topic, name, type_hash(name)),
                bytes(serialize(get_message(name)())),
            )
            for topic, name in _TOPICS.items()
        ]
        self._request = bytes(serialize(get_service(_SERVICE).Request()))

    def attack(self) -> None:
        """Send one random or damaged request, token or message."""
        chance = self._chance
        attachment = bytes_of(chance, self._attachment)
        kind = chance.randrange(10)
        if kind == 0:
            node = chance.choice(_NODES)
            key = topic_key(self._domain, f"/{node}/get_parameters", _SERVICE, type_hash(_SERVICE))
            payload = bytes_of(chance, self._request)
            self._session.get(key, payload=payload, attachment=attachment, timeout=1.0)
        elif kind == 1:
            text = text_of(chance, _TOKEN.format(domain=self._domain))
            try:
                token = self._session.liveliness().declare_token(text)
            except zenoh.ZError:
                return  # not a valid key expression
            token.undeclare()
        else:
            key, good = chance.choice(self._targets)
            self._session.put(key, bytes_of(chance, good), attachment=attachment)


def main() -> None:
    """Attack the nodes; exit status 1 if one then does not answer or has logged a traceback."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with own_graph(), contextlib.ExitStack() as stack:
        said = {name: stack.enter_context(tempfile.TemporaryFile()) for name in _NODES}
        nodes = {
            name: subprocess.Popen(
                [*_RUN, name, "--ros-args", "-p", "use_sim_time:=true"],
                stderr=said[name],
            )
            for name in _NODES
        }
        healthy = True
        with Context() as context, Node("attacker", context=context) as node:
            asks = {
                name: node.create_client(get_service(_SERVICE), f"/{name}/get_parameters")
                for name in _NODES
            }
            for client in asks.values():
                assert client.wait_for_service(20)
            attacker = Attacker(context, random.Random(options.seed))
            for _ in range(options.count):
                attacker.attack()
            for name, client in asks.items():
                answer = client.call(client.srv_type.Request(names=["use_sim_time"]), 30)
                healthy = healthy and answer is not None
                print(f"{name}: {'answers' if answer is not None else 'does not answer'}")
        for name, process in nodes.items():
            process.terminate()
            process.wait(timeout=30)
            said[name].seek(0)
            lines = said[name].read().splitlines()
            tracebacks = sum(b"Traceback" in line for line in lines)
            healthy = healthy and not tracebacks
            print(
                f"{name}: {len(lines)} lines, {tracebacks} tracebacks; the last one: {lines[-1:]}"
            )
    sys.exit(0 if healthy else 1)


if __name__ == "__main__":
    main()
