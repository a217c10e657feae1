"""Action servers and clients, over three services and two topics each.

Source: rcl_action and rclpy's action client and server; the order in which the endpoints are made
and the messages are sent is theirs.
"""
