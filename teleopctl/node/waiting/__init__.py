"""Waiting by hand: rclpy's wait sets, and what programs have executors wait for besides."""
