"""Gives the decoders hostile inputs: they answer, or refuse with the error that they name.

``python -m tests.fuzz.decoders [--count N] [--seed N]``
"""

from __future__ import annotations

import argparse
import collections
import random
import time
from collections.abc import Callable

from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces import deserialize, get_message, serialize
from teleopctl.wire import decode_attachment, encode_attachment
from teleopctl.wire.keys import parse_topic_key
from teleopctl.wire.qos import parse_qos
from teleopctl.wire.tokens import parse_token
from tests.fuzz.inputs import bytes_of, text_of

# Strings, sequences, nested messages, fixed arrays, numbers of every width.
_TYPES = (
    "std_msgs/msg/String",
    "sensor_msgs/msg/JointState",
    "tf2_msgs/msg/TFMessage",
    "sensor_msgs/msg/PointCloud2",
    "sensor_msgs/msg/Imu",
    "trajectory_msgs/msg/JointTrajectory",
    "rcl_interfaces/msg/ParameterEvent",
    "rosgraph_msgs/msg/Clock",
)
_TOKEN = (
    "@ros2_lv/0/abc123/1/2/MP/%/%/talker/%chatter/std_msgs::msg::dds_::String_/RIHS01_ab/"
    "::,10:,:,:,,"
)
_KEY = "0/chatter/std_msgs::msg::dds_::String_/RIHS01_ab"

Trial = Callable[[random.Random], bool]


def _message_trial(type_name: str) -> Trial:
    message_class = get_message(type_name)
    good = bytes(serialize(message_class()))

    def trial(chance: random.Random) -> bool:
        try:
            deserialize(bytes_of(chance, good), message_class)
        except InvalidMessageError:
            return False
        return True

    return trial


def _trials() -> dict[str, Trial]:
    attachment = encode_attachment(1, 2, bytes(16))
    trials = {name: _message_trial(name) for name in _TYPES}
    trials["attachment"] = lambda chance: (
        decode_attachment(bytes_of(chance, attachment)) is not None
    )
    trials["token"] = lambda chance: parse_token(text_of(chance, _TOKEN)) is not None
    trials["key"] = lambda chance: parse_topic_key(text_of(chance, _KEY)) is not None
    trials["qos"] = lambda chance: parse_qos(text_of(chance, "::,10:,:,:,,")) is not None
    return trials


def main() -> None:
    """Run the trials of the command line; an exception that is not documented ends the program."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    chance = random.Random(options.seed)
    trials = _trials()
    names = list(trials)
    outcomes: collections.Counter[tuple[str, bool]] = collections.Counter()
    slowest = (0.0, "")
    for _ in range(options.count):
        name = chance.choice(names)
        began_s = time.perf_counter()
        taken = trials[name](chance)
        slowest = max(slowest, (time.perf_counter() - began_s, name))
        outcomes[name, taken] += 1
    for name in names:
        print(f"{name}: {outcomes[name, True]} taken, {outcomes[name, False]} refused")
    print(f"slowest: {slowest[0] * 1e3:.1f} ms ({slowest[1]})")


if __name__ == "__main__":
    main()
