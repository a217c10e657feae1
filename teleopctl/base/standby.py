"""Standby processes: programs that import their modules before their arguments are known.

`launch` starts one for the simulator and evaluates its file meanwhile: importing MuJoCo takes as
long as that. Arguments and environment come through the process's standard input, as JSON. A
standby process whose input is closed without them ends, so that none outlives its launch.
"""

from __future__ import annotations

import json
import os
import sys

from teleopctl.base.typed import TYPE_CHECKING, Mapping, Sequence

if TYPE_CHECKING:
    from typing import IO

VARIABLE = "TELEOPCTL_STANDBY"
"""Environment variable that makes ``python -m teleopctl.nodes`` a standby process."""


def send_order(pipe: IO[bytes], arguments: Sequence[str], environment: Mapping[str, str]) -> None:
    """Send the arguments and the environment to a standby process, and close the pipe.

    Raises:
        OSError: The process has ended.
    """
    with pipe:
        order = {"arguments": list(arguments), "environment": dict(environment)}
        pipe.write(json.dumps(order).encode())


def receive_order() -> bool:
    """Wait for this process's arguments and environment, and set both; return False at the end.

    The standard input is empty from then on.
    """
    received = b""
    while part := os.read(0, 1 << 16):
        received += part
    if not received:
        return False
    empty = os.open(os.devnull, os.O_RDONLY)
    os.dup2(empty, 0)
    os.close(empty)
    order = json.loads(received)
    os.environ.clear()
    os.environ.update(order["environment"])
    sys.argv[1:] = order["arguments"]
    return True
