"""Missing modules: an extra's is reported with the extra that installs it, others with advice.

This is a separate module, so that verbs that check for an optional library load nothing else.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from teleopctl.errors import MissingExtraError

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
_MOVEIT = (
    "pymoveit2, the services and actions of move_group, and teleopctl.RunningArm move arms from "
    "Python."
)
_RQT = "Plug-ins of rqt need Qt, which is not here; the page (`teleopctl view`) stands for rqt."
_NOT_SERVED = {
    "moveit": f"moveit_py is a binding of MoveIt's C++ library, which is not here: {_MOVEIT}",
    "PyKDL": "PyKDL is a binding of a C++ library, which is not here; teleopctl kinematics and "
    "tf2_geometry_msgs have chains and frames.",
    "python_qt_binding": _RQT,
    "qt_gui": _RQT,
    "rmf_adapter": "rmf_adapter is a binding of Open-RMF's C++ library, which is not here.",
    "moveit_commander": f"moveit_commander is of ROS 1: {_MOVEIT}",
}
# Distributions whose modules have other names.
_DISTRIBUTIONS = {
    "cv2": "opencv-python-headless",
    "PIL": "pillow",
    "bosdyn": "bosdyn-client bosdyn-api",
    "catkin_pkg": "catkin-pkg",
    "grpc": "grpcio",
    "paho": "paho-mqtt",
    "quaternion": "numpy-quaternion",
    "serial": "pyserial",
    "simple_pid": "simple-pid",
    "socketio": "python-socketio",
    "urdf_parser_py": "urdf-parser-py",
    "skimage": "scikit-image",
    "sklearn": "scikit-learn",
    "smbus": "smbus2",
    "usb": "pyusb",
    "yaml": "PyYAML",
}
_DISTRIBUTIONS |= {
    name: name
    for name in (
        *("carla", "cflib", "cma", "fastapi", "filelock", "flask", "matplotlib", "ntplib"),
        *("open3d", "pandas", "pygame", "pymap3d", "pymycobot", "pynput", "pyproj"),
        *("pyquaternion", "pyrealsense2", "requests", "rospkg", "rowan", "scipy", "shapely"),
        *("torch", "transforms3d", "ultralytics", "uvicorn"),
    )
}
_OF_INTERFACES = ("_msgs", "_srvs", "_interfaces", "_actions")


@contextmanager
def extra(name: str, *modules: str) -> Iterator[None]:
    """Turn a failed import of given modules in a ``with`` block into an error that names the extra.

    Args:
        name: Name of the extra in `pyproject.toml`.
        modules: Top-level modules that the extra installs. If another module is missing, which is
            a defect, its ModuleNotFoundError passes through.

    Raises:
        MissingExtraError: One of the modules is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] not in modules:
            raise
        raise MissingExtraError(
            f"This needs {error.name.partition('.')[0]}, which is not installed",
            hint=f"Install it with: pip install {_requirement(name)}",
        ) from error


def _requirement(name: str) -> str:
    """Requirement for pip that installs the extra from the source of this installation."""
    from importlib.metadata import PackageNotFoundError, distribution

    record = None
    with suppress(PackageNotFoundError):
        record = distribution("teleopctl").read_text("direct_url.json")
    if record is not None:
        source = _source(record)
    else:
        # No record: a checkout on the path that is not installed, or a package of an index.
        checkout = Path(__file__).parents[2]
        source = checkout if (checkout / "pyproject.toml").is_file() else None
    if source is None:
        return f"'teleopctl[{name}]'"
    if isinstance(source, str):
        return f"'teleopctl[{name}] @ {source}'"
    with suppress(OSError):  # The current folder may be gone.
        if source.samefile("."):
            return f"'.[{name}]'"
    return f"'{source}[{name}]'"


def _source(record: str) -> Path | str | None:
    """Folder or URL in a record of PEP 610; None if the folder does not exist."""
    import json
    from urllib.parse import urlsplit
    from urllib.request import url2pathname

    origin = json.loads(record)
    url = str(origin["url"])
    if "dir_info" in origin:
        folder = Path(url2pathname(urlsplit(url).path))
        return folder if folder.is_dir() else None
    if "vcs_info" in origin:
        return f"{origin['vcs_info']['vcs']}+{url}@{origin['vcs_info']['commit_id']}"
    return url


def missing_module_hint(error: BaseException) -> str | None:
    """Return advice about a module that an import did not find; None if there is none.

    Args:
        error: Any exception; only a ``ModuleNotFoundError`` has a hint.
    """
    name = getattr(error, "name", None) if isinstance(error, ModuleNotFoundError) else None
    if not name:
        return None
    package = str(name).partition(".")[0]
    if package in _ROS_1:
        return f"{package} is of ROS 1; in ROS 2 it is {_ROS_1[package]}."
    if package in _NOT_SERVED:
        return _NOT_SERVED[package]
    if package in _DISTRIBUTIONS:
        return f"It is not installed: pip install {_DISTRIBUTIONS[package]}"
    if package.endswith(_OF_INTERFACES):
        return (
            f"No package {package} with interfaces is found: put its folder, which has its "
            "package.xml, on TELEOPCTL_PACKAGE_PATH."
        )
    return None
