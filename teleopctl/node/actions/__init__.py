"""Action servers and clients, over three services and two topics each.

Source: rcl_action and rclpy's action client and server, also for the order in which endpoints are
created and messages are sent.
"""
