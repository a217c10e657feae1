"""``rclpy.action``. Actions are not served yet; importing them says so."""

raise ImportError(
    "rclpy.action: this version of teleopctl has no actions in its client library", name=__name__
)
