"""The ROS 2 workflow in one pip install.

PYTEST_DONT_REWRITE: pytest reads this word here, and warns otherwise, as of a plug-in's package
that comes too late for its rewriting of ``assert``, when Python has imported teleopctl at its start
(``teleopctl python -m pytest``).
"""

__version__ = "0.1.0"


def activate() -> None:
    """Let this process import ROS 2's Python packages, such as ``rclpy`` and ``std_msgs.msg``.

    For a program of one's own, before it imports them. Those that are really installed are used
    instead. Idempotent.
    """
    from teleopctl.compat import activation

    activation.activate()
