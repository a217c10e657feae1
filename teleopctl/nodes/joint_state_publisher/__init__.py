"""``joint_state_publisher``, and ``joint_state_publisher_gui`` with sliders on a page."""
