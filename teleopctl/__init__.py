"""The ROS 2 workflow in one pip install."""

__version__ = "0.1.0"


def activate() -> None:
    """Let this process import ROS 2's Python packages, such as ``rclpy`` and ``std_msgs.msg``.

    For a program of one's own, before it imports them. Those that are really installed are used
    instead. Idempotent.
    """
    from teleopctl.compat import activation

    activation.activate()
