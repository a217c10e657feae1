"""``rclpy.lifecycle``. Managed nodes are not served yet; importing them says so."""

raise ImportError(
    "rclpy.lifecycle: this version of teleopctl has no managed (lifecycle) nodes", name=__name__
)
