"""Advice on modules that a user's program imports and that are not installed."""

from __future__ import annotations

_ROS_1 = {
    "rospy": "rclpy",
    "roslib": "rclpy and ament_index_python",
    "rosparam": "the parameters of rclpy's nodes",
    "rosbag": "rosbag2_py",
    "roslaunch": "launch and launch_ros",
    "actionlib": "rclpy.action",
    "tf": "tf2_ros",
    "dynamic_reconfigure": "the parameters of rclpy's nodes",
}
# Distributions whose modules have other names.
_DISTRIBUTIONS = {
    "cv2": "opencv-python-headless",
    "PIL": "pillow",
    "serial": "pyserial",
    "skimage": "scikit-image",
    "sklearn": "scikit-learn",
    "smbus": "smbus2",
    "usb": "pyusb",
    "yaml": "PyYAML",
}
_DISTRIBUTIONS |= {
    name: name
    for name in ("matplotlib", "pandas", "pygame", "pynput", "requests", "scipy", "torch")
}
_OF_INTERFACES = ("_msgs", "_srvs", "_interfaces", "_actions")


def missing_module_hint(error: BaseException) -> str | None:
    """Return what to do about a module that an import did not find; None if that is not known.

    Args:
        error: Any exception; only a ``ModuleNotFoundError`` has a hint.
    """
    name = getattr(error, "name", None) if isinstance(error, ModuleNotFoundError) else None
    if not name:
        return None
    package = str(name).partition(".")[0]
    if package in _ROS_1:
        return f"{package} is of ROS 1; in ROS 2 it is {_ROS_1[package]}."
    if package in _DISTRIBUTIONS:
        return f"It is not installed: pip install {_DISTRIBUTIONS[package]}"
    if package.endswith(_OF_INTERFACES):
        return (
            f"No package {package} with interfaces is found: put its folder, which has its "
            "package.xml, on TELEOPCTL_PACKAGE_PATH."
        )
    return None
