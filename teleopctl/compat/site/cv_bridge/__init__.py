"""``cv_bridge``: images as numpy arrays and back."""

from cv_bridge.core import CvBridge, CvBridgeError

__all__ = ["CvBridge", "CvBridgeError"]
