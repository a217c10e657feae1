"""``rclpy.wait_for_message``. Reception of one message, with a temporary subscription."""

from teleopctl.interfaces import MessageT
from teleopctl.node import (
    Future,
    Node,
    QoSProfile,
    SingleThreadedExecutor,
    spin_until_future_complete,
)

__all__ = ["wait_for_message"]


def wait_for_message(
    msg_type: type[MessageT],
    node: Node,
    topic: str,
    *,
    qos_profile: QoSProfile | int = 1,
    time_to_wait: float = -1,
) -> tuple[bool, MessageT | None]:
    """Wait for the next message of a topic.

    Args:
        msg_type: Message class.
        node: Whose subscription is used; the call spins it.
        topic: Name of the topic.
        qos_profile: Quality of service of the subscription.
        time_to_wait: Longest wait in seconds; negative waits for ever.

    Returns:
        Whether one came, and the message.
    """
    future: Future[MessageT] = Future()
    subscription = node.create_subscription(msg_type, topic, future.set_result, qos_profile)
    executor = SingleThreadedExecutor(context=node.context)  # the global one has the default's
    try:
        spin_until_future_complete(node, future, executor, time_to_wait)
    finally:
        executor.shutdown()
        node.destroy_subscription(subscription)
    return future.done(), future.result()
