"""Demo of matched events: a node logs when publishers and subscriptions match its own."""

from __future__ import annotations

import rclpy
from rclpy.event_handler import (
    PublisherEventCallbacks,
    QoSPublisherMatchedInfo,
    QoSSubscriptionMatchedInfo,
    SubscriptionEventCallbacks,
)
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription
from rclpy.task import Future
from std_msgs.msg import String

_PUBLISHED = "pub_topic_matched_event_detect"
_SUBSCRIBED = "sub_topic_matched_event_detect"
_LONGEST_WAIT_S = 10.0


class MatchedEventDetectNode(Node):
    """Node that logs changes in how many endpoints match its publisher and its subscription."""

    def __init__(self) -> None:
        super().__init__("matched_event_detection_node")
        self.event: Future[bool] = Future()
        self._connected = {"subscription": False, "publisher": False}
        self._publisher = self.create_publisher(
            String,
            _PUBLISHED,
            10,
            event_callbacks=PublisherEventCallbacks(matched=self._subscription_matched),
        )
        self._subscription = self.create_subscription(
            String,
            _SUBSCRIBED,
            lambda _: None,
            10,
            event_callbacks=SubscriptionEventCallbacks(matched=self._publisher_matched),
        )

    def _subscription_matched(self, info: QoSPublisherMatchedInfo) -> None:
        self._log_match("subscription", info)

    def _publisher_matched(self, info: QoSSubscriptionMatchedInfo) -> None:
        self._log_match("publisher", info)

    def _log_match(
        self, what: str, info: QoSPublisherMatchedInfo | QoSSubscriptionMatchedInfo
    ) -> None:
        say = self.get_logger().info
        if not self._connected[what]:
            if info.current_count:
                say(f"First {what} is connected.")
        elif info.current_count:
            say(
                f"The changed number of connected {what} is {info.current_count_change} and "
                f"current number of connected {what} is {info.current_count}"
            )
        else:
            say(f"Last {what} is disconnected.")
        self._connected[what] = bool(info.current_count)
        self.event.set_result(True)


class _MatchingNodes:
    """Nodes whose endpoints match those of `MatchedEventDetectNode`, one after the other.

    Args:
        watched: Node that logs the matches.
    """

    def __init__(self, watched: MatchedEventDetectNode) -> None:
        self._watched = watched
        self._executor = SingleThreadedExecutor()
        self._subscriber = Node("multi_sub_node")
        self._publisher = Node("multi_pub_node")
        self._nodes = (watched, self._subscriber, self._publisher)
        for node in self._nodes:
            self._executor.add_node(node)

    def run(self) -> None:
        """Create and destroy endpoints one by one, and wait for the matched event of each."""
        first, second = self._subscribe(), self._subscribe()
        self._unsubscribe(first)
        self._unsubscribe(second)
        one, other = self._advertise(), self._advertise()
        self._unadvertise(one)
        self._unadvertise(other)

    def close(self) -> None:
        """Destroy all nodes of the demo."""
        self._executor.shutdown()
        for node in self._nodes:
            node.destroy_node()

    def _subscribe(self) -> Subscription[String]:
        self._subscriber.get_logger().info("Create a new subscription.")
        made = self._subscriber.create_subscription(String, _PUBLISHED, lambda _: None, 10)
        self._await_event()
        return made

    def _unsubscribe(self, subscription: Subscription[String]) -> None:
        self._subscriber.get_logger().info("Destroy a subscription.")
        self._subscriber.destroy_subscription(subscription)
        self._await_event()

    def _advertise(self) -> Publisher[String]:
        self._publisher.get_logger().info("Create a new publisher.")
        made = self._publisher.create_publisher(String, _SUBSCRIBED, 10)
        self._await_event()
        return made

    def _unadvertise(self, publisher: Publisher[String]) -> None:
        self._publisher.get_logger().info("Destroy a publisher.")
        self._publisher.destroy_publisher(publisher)
        self._await_event()

    def _await_event(self) -> None:
        self._executor.spin_until_future_complete(self._watched.event, _LONGEST_WAIT_S)
        self._watched.event = Future()


def matched_event_detect(args: list[str] | None = None) -> None:
    """Run the demo of matched events: endpoints come and go, and a node logs each match."""
    rclpy.init(args=args)
    others = _MatchingNodes(MatchedEventDetectNode())
    try:
        others.run()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C before the end
    finally:
        others.close()
        rclpy.try_shutdown()
