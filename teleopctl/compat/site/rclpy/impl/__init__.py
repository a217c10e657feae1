"""``rclpy.impl``. Classes of rclpy's implementation that programs import for type annotations."""
