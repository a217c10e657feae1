"""``tf2_ros.buffer_client``. A buffer that asks another process."""

from teleopctl.tf import BufferClient

__all__ = ["BufferClient"]
