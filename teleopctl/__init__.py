"""The ROS 2 workflow in one pip install: robots, simulation, control, bags and the ROS graph.

    >>> import teleopctl
    >>> robot = teleopctl.load_robot("package://teleop_description/urdf/teleop.urdf.xacro")
    >>> robot.actuated_joint_names
    ['joint_1', 'joint_2', 'joint_3', 'joint_4']
    >>> simulation = teleopctl.RobotSimulation(robot)
    >>> simulation.command({"joint_1": 0.5})
    >>> simulation.step(100)  # one second
    >>> round(simulation.positions["joint_1"], 3)
    0.5

Each name has its own help with an example, such as ``help(teleopctl.read_bag)``.

Robots and simulation:

    load_robot           read a URDF, xacro, SDF or MJCF file
    Robot                links, joints, meshes, forward kinematics, MuJoCo model
    RobotJoint           limits, axis and mimic of a joint
    RobotMesh            a mesh file and its pose on a link
    RobotSimulation      MuJoCo physics, stepped by the program

Kinematics:

    Arm                  forward and inverse kinematics, plans and servo of a group of joints
    IkSolution           a solution, or the nearest positions and what limits them
    MotionSettings       planner, times and limits of a plan
    RunningArm           an arm of the running robot: planned motions, and its gripper
    MotionResult         end of a motion, as measured

Control:

    ControlStack         ros2_control's controllers and hardware, stepped by the program
    ControllerInterface  base class of controllers
    InterfaceConfiguration, InterfaceConfigurationType
                         the interfaces that a controller claims

Bags:

    read_bag             decoded messages (DecodedMessage), by topic and time
    read_raw_bag         messages as bytes (BagMessage)
    open_bag             a Bag with its metadata, attachments and messages
    BagWriter            write a bag; BagTopic describes a topic

ROS graph:

    open_node            start a Node, with rclpy's methods
    watch_graph          snapshots (Graph) of nodes, topics and services, after each change
    activate             make rclpy and message packages importable

Errors:

    TeleopctlError       base class of all errors; see teleopctl.errors
    PlanningError        no motion was found, with MoveIt's code
    ExecutionError       a motion did not reach its end

Programs may also use the packages of ROS 2 (``rclpy``, ``tf2_ros``, ``std_msgs.msg``, …), the base
classes of plug-ins, and ``teleopctl.testing``. All other modules are internal. The names are
provisional until version 1.0: a release may change them, and lists that in the changelog.

(For pytest, which has no assert to rewrite here: PYTEST_DONT_REWRITE)
"""

# PYTEST_DONT_REWRITE in the docstring: without it, pytest warns that it cannot rewrite the plug-in
# when Python imports teleopctl at its start (``teleopctl python -m pytest``).

from __future__ import annotations

from teleopctl.base import __version__ as __version__
from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.api.graph import watch_graph as watch_graph
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
        DecodedMessage as DecodedMessage,
        open_bag as open_bag,
    )
    from teleopctl.commander import (
        ExecutionError as ExecutionError,
        MotionResult as MotionResult,
        RunningArm as RunningArm,
    )
    from teleopctl.compat.activation import activate as activate
    from teleopctl.control import (
        ControllerInterface as ControllerInterface,
        ControlStack as ControlStack,
        InterfaceConfiguration as InterfaceConfiguration,
        InterfaceConfigurationType as InterfaceConfigurationType,
    )
    from teleopctl.errors import TeleopctlError as TeleopctlError
    from teleopctl.kinematics import (
        Arm as Arm,
        IkSolution as IkSolution,
        MotionSettings as MotionSettings,
        PlanningError as PlanningError,
    )
    from teleopctl.node import Node as Node, open_node as open_node
    from teleopctl.wire import Graph as Graph
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
