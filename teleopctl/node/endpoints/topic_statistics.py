"""Topic statistics of a subscription, published as rclcpp does."""

from __future__ import annotations

import math
import threading
import time

from teleopctl.base.typed import TYPE_CHECKING, Any, NamedTuple
from teleopctl.interfaces import get_message, split
from teleopctl.node.values.qos import QoSProfile

if TYPE_CHECKING:
    from teleopctl.node.endpoints.publisher import Publisher


class TopicStatisticsOptions(NamedTuple):
    """Options for publishing a subscription's topic statistics (message age and period).

    Attributes:
        publish_period_sec: Length of a window in seconds of wall time; positive.
        publish_topic: Topic on which ``statistics_msgs/msg/MetricsMessage`` is published.
        qos_profile: QoS profile of that publisher.
    """

    publish_period_sec: float = 1.0
    publish_topic: str = "/statistics"
    qos_profile: QoSProfile = QoSProfile(depth=10)

    def check(self) -> None:
        """Raise ValueError unless the publish period is positive (ours)."""
        if self.publish_period_sec <= 0:
            raise ValueError(
                "the period of topic statistics must be positive, which "
                f"{self.publish_period_sec} s is not"
            )


class Measurements:
    """Running mean, extremes and standard deviation of measurements.

    Mean and sum of squared differences are updated with each measurement (Welford 1962).
    """

    def __init__(self) -> None:
        self._count = 0
        self._mean = 0.0
        self._squares = 0.0
        self._min = math.inf
        self._max = -math.inf

    def add(self, value: float) -> None:
        """Add a measurement to the running statistics."""
        before = value - self._mean
        self._count += 1
        self._mean += before / self._count
        self._squares += before * (value - self._mean)
        self._min = min(self._min, value)
        self._max = max(self._max, value)

    def data_points(self) -> list[tuple[int, float]]:
        """Return mean, maximum, minimum, count and deviation as pairs of data type and value.

        Mean, maximum, minimum, number and standard deviation of the whole window. Without
        measurements all are NaN except the number.
        """
        if not self._count:
            return [(1, math.nan), (3, math.nan), (2, math.nan), (5, 0.0), (4, math.nan)]
        deviation = math.sqrt(self._squares / self._count)
        return [
            (1, self._mean),
            (3, self._max),
            (2, self._min),
            (5, float(self._count)),
            (4, deviation),
        ]


class TopicStatistics:
    """Measurement of a subscription's message ages and periods, published per time window.

    Args:
        node_name: Name of the node, published as the measurement source.
        publisher: Publisher of the statistics.
    """

    # Any: message classes are generated on first use.
    def __init__(self, node_name: str, publisher: Publisher[Any]) -> None:
        self._node_name = node_name
        self._publisher = publisher
        self._lock = threading.Lock()
        self._age_ms = Measurements()
        self._period_ms = Measurements()
        self._last_ns: int | None = None
        self._window_start_ns = time.time_ns()

    def on_message(self, source_ns: int | None) -> None:
        """Add a received message's age, by its source time, and period to the window's statistics.

        Args:
            source_ns: Source time of the message, in nanoseconds since the epoch; None if unknown.
        """
        now_ns = time.time_ns()
        with self._lock:
            if source_ns is not None:
                self._age_ms.add((now_ns - source_ns) / 1e6)
            if self._last_ns is not None:
                self._period_ms.add((now_ns - self._last_ns) / 1e6)
            self._last_ns = now_ns

    def publish(self) -> None:
        """Publish the statistics of the current window, and start a new window."""
        now_ns = time.time_ns()
        with self._lock:
            measured = (("message_age", self._age_ms), ("message_period", self._period_ms))
            start_ns, self._window_start_ns = self._window_start_ns, now_ns
            self._age_ms, self._period_ms = Measurements(), Measurements()
        point = get_message("statistics_msgs/msg/StatisticDataPoint")
        start, stop = _stamp(start_ns), _stamp(now_ns)
        for name, measurements in measured:
            self._publisher.publish(
                self._publisher.msg_type(
                    measurement_source_name=self._node_name,
                    metrics_source=name,
                    unit="ms",
                    window_start=start,
                    window_stop=stop,
                    statistics=[
                        point(data_type=kind, data=value)
                        for kind, value in measurements.data_points()
                    ],
                )
            )


# Any: message classes are generated on first use.
def _stamp(nanoseconds: int) -> Any:
    sec, nanosec = split(nanoseconds)
    return get_message("builtin_interfaces/msg/Time")(sec=sec, nanosec=nanosec)
