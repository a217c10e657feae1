"""Controllers and hardware without ROS: nodes, actions and cycles that stay in memory."""
