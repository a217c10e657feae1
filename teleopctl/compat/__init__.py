"""Import names of ROS 2's Python packages, such as ``rclpy`` and ``launch``, for user programs.

``site/`` has real packages (``rclpy``, ``tf2_ros``, …) and is one entry of the module search path;
no code imports them through this package. A finder provides the message packages, one for each
package with interface definitions. ``activation`` installs both.

May import `bag`, `control`, `interfaces`, `launch`, `node`, `robot` and `tf`, and what every
package may: `base`, `errors`, `packages` and `plugins`.
"""
