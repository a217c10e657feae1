"""The kinds of plug-ins that programs and nodes load, with teleopctl's own plug-ins."""

from __future__ import annotations

from teleopctl.plugins import programs
from teleopctl.plugins.command_line import COMPLETIONS, VERBS
from teleopctl.plugins.lookup import Kind

NODES = Kind("node", "teleopctl.nodes", programs.NODES)
"""Programs of packages, as ``package/executable``: functions that take no argument."""

COMPONENTS = Kind("component", "rclpy_components", programs.COMPONENTS)
"""Nodes that a component container loads, as ``package::Class``; see
`teleopctl.packages.components`. Distributions register components as for ROS 2's
`rclpy_components`."""

_CONTROLLERS = "teleopctl.control.controllers"

CONTROLLERS = Kind(
    "controller",
    "teleopctl.controllers",
    {
        name: f"{_CONTROLLERS}.{module}:{name.partition('/')[2]}"
        for module, names in {
            "admittance.controller": "admittance_controller/AdmittanceController",
            "battery_state_broadcaster": "battery_state_broadcaster/BatteryStateBroadcaster",
            "chained_filter_controller": "chained_filter_controller/ChainedFilter",
            "forward_command_controller": (
                "effort_controllers/JointGroupEffortController "
                "forward_command_controller/ForwardCommandController "
                "forward_command_controller/MultiInterfaceForwardCommandController "
                "position_controllers/JointGroupPositionController "
                "velocity_controllers/JointGroupVelocityController"
            ),
            "gpio_command_controller": "gpio_controllers/GpioCommandController",
            "joint_state_broadcaster": "joint_state_broadcaster/JointStateBroadcaster",
            "joint_trajectory.controller": "joint_trajectory_controller/JointTrajectoryController",
            "mobile_base.diff_drive": "diff_drive_controller/DiffDriveController",
            "mobile_base.mecanum": "mecanum_drive_controller/MecanumDriveController",
            "mobile_base.omni_wheel": "omni_wheel_drive_controller/OmniWheelDriveController",
            "mobile_base.steering": (
                "ackermann_steering_controller/AckermannSteeringController "
                "bicycle_steering_controller/BicycleSteeringController "
                "tricycle_steering_controller/TricycleSteeringController"
            ),
            "mobile_base.tricycle": "tricycle_controller/TricycleController",
            "passthrough_controller": "passthrough_controller/PassthroughController",
            "pid_controller": "pid_controller/PidController",
            "pose_broadcaster": "pose_broadcaster/PoseBroadcaster",
            "sensor_broadcasters": (
                "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster "
                "gps_sensor_broadcaster/GPSSensorBroadcaster "
                "imu_sensor_broadcaster/IMUSensorBroadcaster "
                "magnetometer_broadcaster/MagnetometerBroadcaster "
                "range_sensor_broadcaster/RangeSensorBroadcaster"
            ),
            "state_interfaces_broadcaster": (
                "state_interfaces_broadcaster/StateInterfacesBroadcaster"
            ),
        }.items()
        for name in names.split()
    }
    # Name of the joint state broadcaster in ROS 2 Foxy.
    | {
        "joint_state_controller/JointStateController": (
            f"{_CONTROLLERS}.joint_state_broadcaster:JointStateBroadcaster"
        )
    }
    | {
        f"{package}/GripperActionController": (
            f"{_CONTROLLERS}.gripper_action_controller:{kind}GripperActionController"
        )
        for package, kind in (
            ("effort_controllers", "Effort"),
            ("parallel_gripper_action_controller", "Parallel"),
            ("position_controllers", "Position"),
        )
    },
    bases=(f"{_CONTROLLERS}.base:ControllerInterface",),
    direct=True,
    in_sources=True,
)
"""Controllers, by the names that parameter files use as ``type``."""

_FILTERS = f"{_CONTROLLERS}.filters"

FILTERS = Kind(
    "filter",
    "teleopctl.filters",
    {
        "control_filters/ExponentialFilterDouble": f"{_FILTERS}.doubles:ExponentialFilter",
        "control_filters/GravityCompensationWrench": f"{_FILTERS}.wrenches:GravityCompensation",
        "control_filters/LowPassFilterDouble": f"{_FILTERS}.doubles:LowPassFilter",
        "control_filters/LowPassFilterWrench": f"{_FILTERS}.wrenches:WrenchLowPassFilter",
        "control_filters/RateLimiterDouble": f"{_FILTERS}.doubles:RateLimiterFilter",
        "filters/MeanFilterDouble": f"{_FILTERS}.doubles:MeanFilter",
        "filters/MedianFilterDouble": f"{_FILTERS}.doubles:MedianFilter",
        "filters/TransferFunctionFilterDouble": f"{_FILTERS}.doubles:TransferFunctionFilter",
    },
    bases=(f"{_FILTERS}.base:FilterBase",),
)
"""Filters of measured values, by the names that parameter files use as ``type`` in chains."""

_TOPIC = "teleopctl.control.hardware.topic:JointStateTopicSystem"

HARDWARE = Kind(
    "hardware plug-in",
    "teleopctl.hardware",
    {
        "fake_components/GenericSystem": "teleopctl.control.hardware.mock:GenericSystem",
        "mock_components/GenericSystem": "teleopctl.control.hardware.mock:GenericSystem",
        "gazebo_ros2_control/GazeboSystem": _TOPIC,
        "gz_ros2_control/GazeboSimSystem": _TOPIC,
        "ign_ros2_control/IgnitionSystem": _TOPIC,
        "mujoco_ros2_control/MujocoSystemInterface": _TOPIC,
        "topic_based_ros2_control/TopicBasedSystem": _TOPIC,
        "topic_based_hardware_interfaces/TopicBasedSystem": _TOPIC,
        "joint_state_topic_hardware_interface/JointStateTopicSystem": _TOPIC,
    },
    bases=("teleopctl.control.hardware.base:HardwareComponentInterface",),
    direct=True,
    in_sources=True,
)
"""Hardware components, by the names that URDFs use as ``<plugin>``."""

PACKAGES = Kind("package", "teleopctl.packages", {})
"""ROS packages of files (``msg/``, ``srv/``, ``action/``, ``launch/``, ``urdf/`` and so on): the
module whose folder has the files. The module is not imported. teleopctl's own packages are folders,
see `teleopctl.packages`."""

_XML = "teleopctl.launch.frontends.xml_file:parse_file"
_YAML = "teleopctl.launch.frontends.yaml_file:parse_file"

LAUNCH_LANGUAGES = Kind(
    "language of launch files",
    "teleopctl.launch_languages",
    {
        ".launch": _XML,
        ".py": "teleopctl.compat.launch_file:read",
        ".xml": _XML,
        ".yaml": _YAML,
        ".yml": _YAML,
    },
)
"""Readers of launch files, by suffix: functions that return the
`teleopctl.launch.model.action.LaunchFile` of a path."""

WRITE_DEFINITIONS = "teleopctl.interfaces.definition_files:write_definitions"
"""Function that writes the definition files of all interfaces that come with teleopctl below a
folder, and returns their paths by package. `teleopctl.packages` is in a lower layer."""

LAUNCH_EXTENSIONS = "teleopctl.compat.launch_extensions:load"
"""Function that loads extensions of ROS 2's own launch, which expose actions and substitutions. The
extensions import ROS 2's packages, which are in a higher layer than `teleopctl.launch`."""

_ACTIONS = "teleopctl.launch.actions"

LAUNCH_ACTIONS = Kind(
    "launch action",
    "teleopctl.launch_actions",
    {
        "append_env": f"{_ACTIONS}.environment:AppendEnvironment",
        "arg": f"{_ACTIONS}.settings:DeclareArgument",
        "bool_arg": f"{_ACTIONS}.settings:DeclareBoolean",
        "executable": f"{_ACTIONS}.process:Executable",
        "for": f"{_ACTIONS}.nesting:For",
        "for_each": f"{_ACTIONS}.nesting:ForEach",
        "group": f"{_ACTIONS}.nesting:Group",
        "gz_server": f"{_ACTIONS}.gazebo:GzServer",
        "gz_spawn_model": f"{_ACTIONS}.gazebo:GzSpawnModel",
        "include": f"{_ACTIONS}.nesting:Include",
        "let": f"{_ACTIONS}.settings:Let",
        "lifecycle_node": f"{_ACTIONS}.process:LifecycleNode",
        "load_composable_node": f"{_ACTIONS}.components:LoadComponents",
        "log": f"{_ACTIONS}.messages:Log",
        "log_debug": f"{_ACTIONS}.messages:LogDebug",
        "log_error": f"{_ACTIONS}.messages:LogError",
        "log_info": f"{_ACTIONS}.messages:LogInfo",
        "log_warning": f"{_ACTIONS}.messages:LogWarning",
        "node": f"{_ACTIONS}.process:Node",
        "node_container": f"{_ACTIONS}.components:NodeContainer",
        "push_ros_namespace": f"{_ACTIONS}.settings:PushNamespace",
        "rep_env": f"{_ACTIONS}.environment:ReplaceEnvironment",
        "reset": f"{_ACTIONS}.settings:Reset",
        "reset_env": f"{_ACTIONS}.environment:ResetEnvironment",
        "ros_gz_bridge": f"{_ACTIONS}.gazebo:RosGzBridge",
        "ros_timer": f"{_ACTIONS}.ros_timer:RosTimer",
        "set_env": f"{_ACTIONS}.environment:SetEnvironment",
        "set_parameter": f"{_ACTIONS}.settings:SetParameter",
        "set_parameters_from_file": f"{_ACTIONS}.settings:SetParametersFromFile",
        "set_remap": f"{_ACTIONS}.settings:SetRemap",
        "set_ros_log_dir": f"{_ACTIONS}.environment:SetRosLogDirectory",
        "set_use_sim_time": f"{_ACTIONS}.settings:SetUseSimTime",
        "shutdown": f"{_ACTIONS}.messages:Shutdown",
        "timer": f"{_ACTIONS}.nesting:TimedEntities",
        "unset_env": f"{_ACTIONS}.environment:UnsetEnvironment",
    },
    bases=("teleopctl.launch.model.action:Action",),
)
"""Actions of launch files, by their names in the files (with underscores)."""

_SUBSTITUTIONS = {
    "ros2_substitutions": "all and anon any command dirname env equals eval exec-in-pkg "
    "file-content filename find-exec find-pkg-prefix find-pkg-share for-var if index "
    "launch_log_dir log_dir not not-equals optenv or param path-join string-join var",
    "extra_substitutions": "file-controllers file-namespace file-param file-update-rate first-file "
    "node-exists world-file",
    "robot_substitutions": "robot robot-arguments robot-controllers robot-is-controlled "
    "robot-namespace robot-remappings simulated-robot with-plugins xacro",
}

LAUNCH_SUBSTITUTIONS = Kind(
    "substitution",
    "teleopctl.launch_substitutions",
    {
        name: f"teleopctl.launch.evaluation.{module}:{name.upper().replace('-', '_')}"
        for module, names in _SUBSTITUTIONS.items()
        for name in names.split()
    },
    bases=("teleopctl.launch.evaluation.substitution:Substitution",),
    classes=False,
)
"""Substitutions of launch files, by the name after ``$(``."""

_SENSORS = "teleopctl.sim.sensors"

SENSORS = Kind(
    "sensor type",
    "teleopctl.sensors",
    {
        "air_pressure": f"{_SENSORS}.heights:AirPressure",
        "altimeter": f"{_SENSORS}.heights:Altimeter",
        "contact": f"{_SENSORS}.contact:Contact",
        "force_torque": f"{_SENSORS}.force_torque:ForceTorque",
        "gps": f"{_SENSORS}.navsat:NavSat",
        "imu": f"{_SENSORS}.imu:Imu",
        "magnetometer": f"{_SENSORS}.magnetometer:Magnetometer",
        "mujoco": "teleopctl.sim.mjcf:MjcfSensor",
        "navsat": f"{_SENSORS}.navsat:NavSat",
        "rangefinder": "teleopctl.sim.mjcf:Rangefinder",
        "touch": "teleopctl.sim.mjcf:Touch",
    }
    | dict.fromkeys(("gpu_lidar", "gpu_ray", "lidar", "ray", "sonar"), f"{_SENSORS}.lidar:Lidar"),
    bases=("teleopctl.sim.sensors.base:Sensor",),
)
"""Simulated sensors, by the type in ``<sensor type="…">``."""

_DEVICES = "teleopctl.teleop.devices"

TELEOP_DEVICES = Kind(
    "teleop device",
    "teleopctl.teleop_devices",
    {
        "gamepad": f"{_DEVICES}.gamepad:Gamepad",
        "joy": f"{_DEVICES}.joy:JoyTopic",
        "keyboard": f"{_DEVICES}.keyboard:TerminalKeys",
        "leader": f"{_DEVICES}.leader:LeaderArm",
    },
    bases=("teleopctl.teleop.device:TeleopDevice",),
    direct=True,
    summaries={
        "gamepad": "A gamepad of this machine",
        "joy": "A gamepad of any machine, by its joy_node",
        "keyboard": "Keys of this terminal",
        "leader": "Another arm of the graph, which the robot follows",
    },
)
"""Teleoperation devices, by name."""

_DISPLAYS = "teleopctl.viewer.displays"

DISPLAYS = Kind(
    "display",
    "teleopctl.viewer_displays",
    {
        "AccelStamped": f"{_DISPLAYS}.geometry:AccelStamped",
        "Axes": f"{_DISPLAYS}.frames:Axes",
        "Camera": f"{_DISPLAYS}.sensors.images:CameraDisplay",
        "DepthCloud": f"{_DISPLAYS}.sensors.depth_cloud:DepthCloud",
        "Grid": f"{_DISPLAYS}.frames:Grid",
        "GridCells": f"{_DISPLAYS}.geometry:GridCells",
        "Image": f"{_DISPLAYS}.sensors.images:Image",
        "InteractiveMarkers": f"{_DISPLAYS}.markers.interactive:InteractiveMarkers",
        "LaserScan": f"{_DISPLAYS}.sensors.points:LaserScan",
        "Map": f"{_DISPLAYS}.sensors.map:Map",
        "Marker": f"{_DISPLAYS}.markers.markers:Marker",
        "MarkerArray": f"{_DISPLAYS}.markers.markers:MarkerArray",
        "MotionPlanning": f"{_DISPLAYS}.moveit.motion_planning:MotionPlanning",
        "Odometry": f"{_DISPLAYS}.poses:OdometryDisplay",
        "ParticleCloud": f"{_DISPLAYS}.poses:ParticleCloud",
        "Path": f"{_DISPLAYS}.poses:PathDisplay",
        "PlanningScene": f"{_DISPLAYS}.moveit.planning_scene:PlanningScene",
        "PointCloud": f"{_DISPLAYS}.sensors.points:PointCloud",
        "PointCloud2": f"{_DISPLAYS}.sensors.points:PointCloud2",
        "PointStamped": f"{_DISPLAYS}.geometry:PointStamped",
        "Polygon": f"{_DISPLAYS}.geometry:Polygon",
        "Pose": f"{_DISPLAYS}.poses:PoseDisplay",
        "PoseArray": f"{_DISPLAYS}.poses:PoseArray",
        "PoseWithCovariance": f"{_DISPLAYS}.poses:PoseWithCovariance",
        "Range": f"{_DISPLAYS}.geometry:Range",
        "RobotModel": f"{_DISPLAYS}.robot_model:RobotModelDisplay",
        "RobotState": f"{_DISPLAYS}.moveit.robot_state:RobotState",
        "TF": f"{_DISPLAYS}.frames:TfDisplay",
        "Trace": f"{_DISPLAYS}.frames:Trace",
        "Trajectory": f"{_DISPLAYS}.moveit.trajectory:TrajectoryDisplay",
        "TwistStamped": f"{_DISPLAYS}.geometry:TwistStamped",
        "Wrench": f"{_DISPLAYS}.geometry:Wrench",
    },
    bases=("teleopctl.viewer.displays.base:Display",),
)
"""Displays of the viewer, by RViz's class names without the package."""

_PANELS = "teleopctl.viewer.panels"

PANELS = Kind(
    "viewer panel",
    "teleopctl.viewer_panels",
    {
        "scene": f"{_PANELS}.scene:ScenePanel",
        "joints": f"{_PANELS}.joints:JointsPanel",
        "controllers": f"{_PANELS}.controllers:ControllersPanel",
        "camera": f"{_PANELS}.camera:CameraPanel",
        "plot": f"{_PANELS}.plots.plot:PlotPanel",
        "topics": f"{_PANELS}.topics:TopicsPanel",
        "send": f"{_PANELS}.send:SendPanel",
        "graph": f"{_PANELS}.graph:GraphPanel",
        "parameters": f"{_PANELS}.parameters:ParametersPanel",
        "log": f"{_PANELS}.log:LogPanel",
        "simulation": f"{_PANELS}.simulation:SimulationPanel",
        "bag": f"{_PANELS}.bag:BagPanel",
        "tools": f"{_PANELS}.tools:ToolsPanel",
    },
    bases=("teleopctl.viewer.panels.base:Panel",),
)
"""Panels of the viewer's page, in the order in which it offers them."""


def kinds() -> list[Kind]:
    """Return all kinds of plug-ins, sorted by entry-point group."""
    here = {value for value in globals().values() if isinstance(value, Kind)}
    return sorted(here | {VERBS, COMPLETIONS}, key=lambda kind: kind.group)
