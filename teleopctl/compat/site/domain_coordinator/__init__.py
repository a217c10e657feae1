"""``domain_coordinator``. ROS domains that no other test of this machine uses."""

import random
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from teleopctl.errors import SystemFailureError

__all__ = ["domain_id"]

# Same as in ROS 2, so that runs of both use different domains.
_DOMAINS = range(1, 101)
_FIRST_PORT = 22119


def _shuffled() -> list[int]:
    return random.sample(_DOMAINS, len(_DOMAINS))


@contextmanager
def domain_id(selector: Callable[[], int] | None = None) -> Iterator[int]:
    """Return a context manager with a ROS domain id that no other test here has.

    Args:
        selector: Function that returns an id to try; None tries all in a random order.

    Raises:
        SystemFailureError: All domains are in use.
    """
    for number in _shuffled() if selector is None else (selector() for _ in _DOMAINS):
        with socket.socket() as taken:
            try:
                taken.bind(("127.0.0.1", _FIRST_PORT + number))
            except OSError:
                continue
            yield number
            return
    raise SystemFailureError(
        f"Launch tests run in all {len(_DOMAINS)} ROS domains",
        hint="Wait for one of them to end, or set ROS_DOMAIN_ID.",
    )
