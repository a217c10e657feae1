"""``rclpy.impl``. What programs take from rclpy's inside for type annotations."""
