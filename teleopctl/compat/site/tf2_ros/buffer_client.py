"""``tf2_ros.buffer_client``. Client of a transform buffer in another process."""

from teleopctl.tf import BufferClient

__all__ = ["BufferClient"]
