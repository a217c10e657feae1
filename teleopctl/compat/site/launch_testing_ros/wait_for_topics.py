"""``launch_testing_ros.wait_for_topics``."""

from __future__ import annotations

import contextlib
import random
import string
import threading
from collections import deque
from collections.abc import Callable, Iterable
from functools import partial
from types import TracebackType
from typing import Any

from rclpy.context import Context
from rclpy.event_handler import QoSSubscriptionMatchedInfo, SubscriptionEventCallbacks
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile


class WaitForTopics:
    """Waits until a message has been received on each of several topics.

    Used in a ``with`` statement, it waits at the beginning and is shut down at the end.

    Args:
        topic_tuples: Names and types of the topics.
        timeout: Seconds to wait.
        messages_received_buffer_length: How many messages of each topic are kept.
        trigger: Called once a publisher is there, with the node and the arguments of `wait`.
        node_namespace: Namespace of the node.
        qos_profile: How to subscribe: a profile, or how many messages are kept.

    Raises:
        TypeError: The trigger cannot be called.
    """

    # Any: messages of whatever types, and a trigger with arguments of its own.
    def __init__(
        self,
        topic_tuples: Iterable[tuple[str, type[Any]]],
        timeout: float = 5.0,
        messages_received_buffer_length: int = 10,
        trigger: Callable[..., Any] | None = None,
        node_namespace: str | None = None,
        qos_profile: QoSProfile | int = 10,
    ) -> None:
        if trigger is not None and not callable(trigger):
            raise TypeError("The passed trigger is not callable")
        self.topic_tuples = list(topic_tuples)
        self.timeout = timeout
        self.messages_received_buffer_length = messages_received_buffer_length
        self.trigger = trigger
        self.qos_profile = qos_profile
        self._received: dict[str, deque[Any]] = {}
        self._all_received = threading.Event()
        self._publisher_is_there = threading.Event()
        self._context = Context()
        self._context.init()
        letters = string.ascii_uppercase + string.digits
        self._node = Node(
            "_test_node_" + "".join(random.choices(letters, k=10)),  # noqa: S311 -- no secret
            context=self._context,
            namespace=node_namespace or "",
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, name="wait-for-topics")
        self._thread.start()

    def _spin(self) -> None:
        with contextlib.suppress(ExternalShutdownException):
            self._executor.spin()

    # Any: arguments of the trigger.
    def wait(self, *args: Any, **kwargs: Any) -> bool:
        """Wait until a new message has been received on each topic; return whether that happened.

        Args:
            args: Arguments of the trigger.
            kwargs: Likewise.
        """
        self._all_received.clear()
        for buffer in self._received.values():
            buffer.clear()
        new = {name: type_ for name, type_ in self.topic_tuples if name not in self._received}
        # All are known before the first message comes.
        for name in new:
            self._received[name] = deque(maxlen=self.messages_received_buffer_length)
        for name, message_type in new.items():
            self._node.create_subscription(
                message_type,
                name,
                partial(self._on_message, name),
                self.qos_profile,
                event_callbacks=SubscriptionEventCallbacks(matched=self._on_match),
            )
        self._publisher_is_there.wait(self.timeout)
        if self.trigger is not None:
            self.trigger(self._node, *args, **kwargs)
        return self._all_received.wait(self.timeout)

    def _on_match(self, info: QoSSubscriptionMatchedInfo) -> None:
        if info.current_count:
            self._publisher_is_there.set()
        else:
            self._publisher_is_there.clear()

    def _on_message(self, name: str, message: Any) -> None:
        self._received[name].append(message)
        if all(self._received.values()):
            self._all_received.set()

    def shutdown(self) -> None:
        """Destroy the node."""
        self._context.try_shutdown()
        self._thread.join()
        self._node.destroy_node()

    def topics_received(self) -> set[str]:
        """Return the topics on which a message has been received."""
        return {name for name, messages in self._received.items() if messages}

    def topics_not_received(self) -> set[str]:
        """Return the topics on which no message has been received."""
        return {name for name, messages in self._received.items() if not messages}

    def received_messages(self, topic_name: str) -> list[Any]:
        """Return the last received messages of a topic.

        Raises:
            KeyError: It is none of the topics.
        """
        if topic_name not in self._received:
            raise KeyError(f"No messages received for topic: {topic_name}")
        return list(self._received[topic_name])

    def __enter__(self) -> WaitForTopics:
        if not self.wait():
            missing = self.topics_not_received()
            self.shutdown()
            raise RuntimeError("Did not receive messages on these topics: ", missing)
        return self

    def __exit__(
        self,
        exception_type: type[BaseException] | None,
        exception: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.shutdown()
