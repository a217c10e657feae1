"""``tf2_ros.transform_listener``. Subscription that fills a buffer."""

from teleopctl.tf import TF_STATIC_TOPIC, TF_TOPIC, TransformListener

DEFAULT_TF_TOPIC = TF_TOPIC
DEFAULT_STATIC_TF_TOPIC = TF_STATIC_TOPIC

__all__ = ["DEFAULT_STATIC_TF_TOPIC", "DEFAULT_TF_TOPIC", "TransformListener"]
