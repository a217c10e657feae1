"""``rclpy_components``: containers of components in Python."""
