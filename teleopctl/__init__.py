"""The ROS 2 workflow in one pip install: the library behind the ``teleopctl`` command.

The names of this module are what programs may rely on, with the packages of ROS 2 (``rclpy``,
``tf2_ros``, ``std_msgs.msg``, …) and `teleopctl.testing`; all other modules are internal. Until
kinematics joins them the names are provisional: a release may still change them, and its changelog
says how. Each is loaded when it is first used.

Describe and simulate:
    `load_robot` reads a URDF, xacro, SDF or MJCF file into a `Robot`: joints with limits, meshes,
    forward kinematics, a MuJoCo model, a yourdfpy object. `RobotSimulation` steps its physics.
    `ControlStack` runs ros2_control's controllers in the program's own loop, such as a
    `ControllerInterface` of yours.

Record:
    `read_bag` yields the decoded messages of a bag, `read_raw_bag` their bytes. `open_bag` and
    `BagWriter` do all that bags can hold.

Take part in the graph:
    `watch_graph` yields snapshots of nodes, topics and services. `open_node` starts a node with
    rclpy's methods. `activate` makes ``import rclpy`` and message packages work.

Errors:
    All errors derive from `TeleopctlError`; see `teleopctl.errors`.

PYTEST_DONT_REWRITE: pytest reads this word here, and warns otherwise, as of a plug-in's package
that comes too late for its rewriting of ``assert``, when Python has imported teleopctl at its start
(``teleopctl python -m pytest``).
"""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

__version__ = "0.1.0"

if TYPE_CHECKING:
    from teleopctl.api.graph import open_node as open_node, watch_graph as watch_graph
    from teleopctl.api.recording import read_bag as read_bag, read_raw_bag as read_raw_bag
    from teleopctl.api.robot import (
        Robot as Robot,
        RobotJoint as RobotJoint,
        RobotMesh as RobotMesh,
        load_robot as load_robot,
    )
    from teleopctl.api.simulation import RobotSimulation as RobotSimulation
    from teleopctl.bag import (
        Bag as Bag,
        BagMessage as BagMessage,
        BagTopic as BagTopic,
        BagWriter as BagWriter,
        Decoded as Decoded,
        open_bag as open_bag,
    )
    from teleopctl.compat.activation import activate as activate
    from teleopctl.control import (
        ControllerInterface as ControllerInterface,
        ControlStack as ControlStack,
        InterfaceConfiguration as InterfaceConfiguration,
        InterfaceConfigurationType as InterfaceConfigurationType,
    )
    from teleopctl.errors import TeleopctlError as TeleopctlError
    from teleopctl.node import Node as Node
    from teleopctl.wire import Graph as Graph
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
