"""Measurement of delays and rates of transforms, as ``tf2_monitor`` does."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

from teleopctl.base.printable import printable_line
from teleopctl.interfaces import get_message, to_seconds
from teleopctl.node import MessageInfo, Node, QoSProfile, qos_profile_latched
from teleopctl.tf.broadcaster import TF_STATIC_TOPIC, TF_TOPIC
from teleopctl.tf.buffer import Buffer
from teleopctl.tf.echo import wait_for_frames
from teleopctl.tf.errors import TransformException
from teleopctl.tf.listener import Senders
from teleopctl.tf.messages import stamp_of

GATHER_S = 10.0
"""Time of data collection before the first results, in seconds, as in tf2_monitor."""

# Number of measurements that tf2_monitor averages over.
_MOST = 1000
_DEPTH = 100
# Periods of measuring the delay of a chain and of printing results, as in tf2_monitor.
_MEASURE_EVERY_S = 0.5
_RESULTS_EVERY_S = 1.0


class Delay(NamedTuple):
    """Average and largest delay between transforms' stamps and arrivals, in seconds."""

    average_s: float
    max_s: float


class FrameDelay(NamedTuple):
    """Frame with the node that publishes it and its `Delay`; no delay for a static frame."""

    name: str
    publisher: str
    delay: Delay | None


class Broadcaster(NamedTuple):
    """Node that broadcasts transforms, with messages' rate and `Delay`; None if all are static."""

    node: str
    rate_hz: float | None
    delay: Delay | None


class MonitorResults(NamedTuple):
    """Result of a `TransformMonitor`: delays of frames and of a chain, and broadcasters.

    ``chain`` is empty and ``net`` is None if all frames are monitored.
    """

    chain: tuple[str, ...]
    net: Delay | None
    frames: tuple[FrameDelay, ...]
    broadcasters: tuple[Broadcaster, ...]

    def text(self) -> str:
        """Return the results as the lines that tf2_monitor prints."""
        return "\n".join(map(printable_line, self._lines()))

    def _lines(self) -> Iterator[str]:
        yield from ("", "", "")
        if self.chain:
            yield f"RESULTS: for {self.chain[0]} to {self.chain[-1]}"
            yield f"Chain is: {' -> '.join(self.chain)}"
        else:
            yield "RESULTS: for all Frames"
        if self.net is not None:
            yield f"Net delay     avg = {self.net.average_s:g}: max = {self.net.max_s:g}"
        yield from ("", "Frames:")
        for frame in self.frames:
            prefix = f"Frame: {frame.name}, published by {frame.publisher}, "
            if frame.delay is None:
                yield f"{prefix}static"
            else:
                average, longest = frame.delay
                yield f"{prefix}Average Delay: {average:g}, Max Delay: {longest:g}"
        yield from ("", "All Broadcasters:")
        for sender in self.broadcasters:
            if sender.rate_hz is None or sender.delay is None:
                yield f"Node: {sender.node} static"
            else:
                average, longest = sender.delay
                yield (
                    f"Node: {sender.node} {sender.rate_hz:g} Hz, "
                    f"Average Delay: {average:g} Max Delay: {longest:g}"
                )


class TransformMonitor:
    """Subscriber to ``/tf`` and ``/tf_static`` that measures delays and rates of transforms.

    The publisher GID of a message identifies the node that sent the message.

    Args:
        node: Node that subscribes; need not be spun. Its clock is compared with the stamps.
    """

    def __init__(self, node: Node) -> None:
        self.buffer = Buffer()
        self._node = node
        self._lock = threading.Lock()
        self._names = Senders(node)
        self._publisher: dict[str, bytes] = {}
        self._delays: dict[str, deque[float]] = {}
        self._senders: dict[bytes, _Sender] = {}
        self._net: deque[float] = deque(maxlen=_MOST)
        message = get_message("tf2_msgs/msg/TFMessage")
        self._subscriptions = [
            node.create_subscription(
                message, TF_TOPIC, self._moved, QoSProfile(depth=_DEPTH), immediate=True
            ),
            node.create_subscription(
                message, TF_STATIC_TOPIC, self._stands, qos_profile_latched, immediate=True
            ),
        ]

    def unregister(self) -> None:
        """Unsubscribe from ``/tf`` and ``/tf_static``."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)

    def measure_chain(self, target: str, source: str) -> None:
        """Measure a chain's present delay once, for `results`; do nothing if it is unconnected."""
        try:
            stamp, _ = self.buffer.lookup(target, source, 0)
        except TransformException:
            return
        now = self._node.get_clock().now().nanoseconds
        with self._lock:
            # A chain of static frames has no stamp, thus no delay.
            self._net.append(to_seconds(now - stamp) if stamp else 0.0)

    def results(self, chain: Sequence[str] = ()) -> MonitorResults:
        """Return the `MonitorResults` so far, for the frames of a chain, or all if it is empty."""
        with self._lock:
            frames = tuple(
                FrameDelay(name, self._names.name(gid), _delay(self._delays.get(name)))
                for name, gid in sorted(self._publisher.items())
                if not chain or name in chain
            )
            # A node with static and moving frames is listed once, with the rate of the moving ones.
            broadcasters = {
                self._names.name(gid): Broadcaster(
                    self._names.name(gid), _rate(sent.times), _delay(sent.delays)
                )
                for gid, sent in sorted(self._senders.items(), key=lambda item: len(item[1].times))
            }
            net = _delay(self._net) if chain else None
        return MonitorResults(tuple(chain), net, frames, tuple(sorted(broadcasters.values())))

    # Any: a TFMessage.
    def _moved(self, message: Any, info: MessageInfo) -> None:
        now = self._node.get_clock().now().nanoseconds
        delays = {
            each.child_frame_id: to_seconds(now - stamp_of(each.header.stamp))
            for each in message.transforms
        }
        sender = self._note_sender(message, info["publisher_gid"])
        with self._lock:
            for frame, delay in delays.items():
                self._delays.setdefault(frame, deque(maxlen=_MOST)).append(delay)
            if delays:
                sender.delays.append(sum(delays.values()) / len(delays))
                sender.times.append(to_seconds(now))
        for each in message.transforms:
            self.buffer.set_transform(each)

    # Any: a TFMessage.
    def _stands(self, message: Any, info: MessageInfo) -> None:
        self._note_sender(message, info["publisher_gid"])
        for each in message.transforms:
            self.buffer.set_transform_static(each)

    # Any: a TFMessage.
    def _note_sender(self, message: Any, gid: bytes) -> _Sender:
        with self._lock:
            # Look the name up now: the node may have ended when the results are computed.
            self._names.name(gid)
            for each in message.transforms:
                self._publisher[each.child_frame_id] = gid
            return self._senders.setdefault(gid, _Sender())


class _Sender:
    """Arrival times and delays of a publisher's last messages, in seconds."""

    def __init__(self) -> None:
        self.times: deque[float] = deque(maxlen=_MOST)
        self.delays: deque[float] = deque(maxlen=_MOST)


def monitor_transforms(
    node: Node,
    chain: tuple[str, str] | None,
    *,
    gather_s: float,
    once: bool,
    show: Callable[[MonitorResults], None],
    say: Callable[[str], object],
    wait: Callable[[str], object],
) -> None:
    """Pass the `MonitorResults` to ``show`` each second, until the context ends.

    Args:
        node: Node that subscribes; need not be spun.
        chain: Target frame and source frame of the chain; None for all frames.
        gather_s: Seconds until the first results.
        once: Whether to stop after the first results.
        show: Called with the results each time they are computed.
        say: Called with the line to print when data collection starts.
        wait: Called each second with the line to print, until the frames are connected.
    """
    monitor = TransformMonitor(node)
    ended = threading.Event()
    node.context.on_shutdown(ended.set)
    try:
        names: list[str] = []
        if chain:
            if not wait_for_frames(monitor.buffer, *chain, ended, wait):
                return
            names = _chain(monitor.buffer, *chain)
        monitored = " -> ".join(chain) if chain else "all frames"
        say(printable_line(f"Gathering data on {monitored} for {gather_s:g} seconds..."))
        due = time.monotonic() + gather_s
        while True:
            if chain:
                monitor.measure_chain(*chain)
            if ended.wait(max(0.0, min(_MEASURE_EVERY_S, due - time.monotonic()))):
                return
            if time.monotonic() >= due:
                due += _RESULTS_EVERY_S
                show(monitor.results(names))
                if once:
                    return
    finally:
        node.context.forget_on_shutdown(ended.set)
        monitor.unregister()


def _chain(buffer: Buffer, first: str, last: str) -> list[str]:
    """The frames from the first to the last."""
    return buffer._chain(last, 0, first, 0, last)  # noqa: SLF001 -- name in tf2


def _delay(delays: Sequence[float] | None) -> Delay | None:
    return Delay(sum(delays) / len(delays), max(0.0, *delays)) if delays else None


def _rate(times: Sequence[float] | None) -> float | None:
    if not times:
        return None
    span = times[-1] - times[0]
    return (len(times) - 1) / span if span > 0 else 0.0
