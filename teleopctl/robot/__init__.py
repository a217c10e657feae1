"""Robot description: xacro, URDF, SDF, MJCF, ``<ros2_control>`` and forward kinematics.

May import `base`, `errors`, `packages`, `plugins` and `tf`.
"""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.robot.any_robot import (
        ChosenControllers as ChosenControllers,
        arguments_text as arguments_text,
        controller_namespace as controller_namespace,
        controller_parameter_files as controller_parameter_files,
        controller_remappings as controller_remappings,
        default_controllers as default_controllers,
        update_rate_problem as update_rate_problem,
        with_absolute_mesh_paths as with_absolute_mesh_paths,
        xacro_arguments as xacro_arguments,
    )
    from teleopctl.robot.description import RobotDescription as RobotDescription
    from teleopctl.robot.elements import to_number as to_number
    from teleopctl.robot.gazebo_plugins.plugin_reader import GroundTruth as GroundTruth
    from teleopctl.robot.gazebo_plugins.table import (
        MotionPlugins as MotionPlugins,
        motion_plugins as motion_plugins,
        tags_of_plugin as tags_of_plugin,
    )
    from teleopctl.robot.gazebo_tag import gazebo_colour as gazebo_colour
    from teleopctl.robot.inertia import joint_inertias as joint_inertias
    from teleopctl.robot.joint_rules import (
        JointLimits as JointLimits,
        SoftLimits as SoftLimits,
        clamped_command_text as clamped_command_text,
    )
    from teleopctl.robot.joints import (
        STOPPING_TIME_S as STOPPING_TIME_S,
        JointModel as JointModel,
        Joints as Joints,
        JointSet as JointSet,
        read_acceleration_limits as read_acceleration_limits,
        stop_decelerations as stop_decelerations,
    )
    from teleopctl.robot.kinematics import (
        MovingSegments as MovingSegments,
        SegmentTree as SegmentTree,
    )
    from teleopctl.robot.mesh_textures import (
        MOST_TEXTURE_BYTES as MOST_TEXTURE_BYTES,
        check_picture as check_picture,
    )
    from teleopctl.robot.meshes import (
        MESH_SUFFIXES as MESH_SUFFIXES,
        InvalidMeshError as InvalidMeshError,
        check_mesh_file as check_mesh_file,
        read_mesh as read_mesh,
    )
    from teleopctl.robot.mjcf.actuators import (
        JointActuator as JointActuator,
        joint_actuators as joint_actuators,
        length_actuator as length_actuator,
    )
    from teleopctl.robot.mjcf.mjcf_as_urdf import ball_joint_names as ball_joint_names
    from teleopctl.robot.mjcf.mjcf_file import Mjcf as Mjcf, load_mjcf as load_mjcf
    from teleopctl.robot.mjcf.sensors import sensor_tags as sensor_tags
    from teleopctl.robot.mjcf.size_limits import (
        check_mjcf as check_mjcf,
        check_mjcf_text as check_mjcf_text,
    )
    from teleopctl.robot.model_file import (
        ModelKind as ModelKind,
        model_kind as model_kind,
        read_model as read_model,
    )
    from teleopctl.robot.repair import repair_urdf as repair_urdf
    from teleopctl.robot.ros2_control_tag import (
        AsyncThread as AsyncThread,
        ComponentInfo as ComponentInfo,
        HardwareInfo as HardwareInfo,
        InterfaceInfo as InterfaceInfo,
        TransmissionEnd as TransmissionEnd,
        TransmissionInfo as TransmissionInfo,
    )
    from teleopctl.robot.scene.loops import (
        Loop as Loop,
        loop_of as loop_of,
        tree_and_loops as tree_and_loops,
    )
    from teleopctl.robot.scene.scene import (
        Scene as Scene,
        SceneBody as SceneBody,
        SceneInertial as SceneInertial,
        SceneJoint as SceneJoint,
        SceneLight as SceneLight,
        SceneModel as SceneModel,
        ScenePose as ScenePose,
        SceneShape as SceneShape,
    )
    from teleopctl.robot.scene.surface import Surface as Surface
    from teleopctl.robot.sdf.includes import gazebo_models as gazebo_models
    from teleopctl.robot.sensor_names import (
        RosNames as RosNames,
        ros_topic as ros_topic,
    )
    from teleopctl.robot.sensor_tag import (
        CameraTag as CameraTag,
        Lens as Lens,
        Noise as Noise,
        PluginTag as PluginTag,
        Rays as Rays,
        RaySweep as RaySweep,
        SensorTag as SensorTag,
    )
    from teleopctl.robot.serial_chain import (
        ChainFrame as ChainFrame,
        SerialChain as SerialChain,
    )
    from teleopctl.robot.simulated_hardware import (
        COMMANDS_TOPIC as COMMANDS_TOPIC,
        RESET_FRAME as RESET_FRAME,
        STATES_TOPIC as STATES_TOPIC,
        SimulatedDescription as SimulatedDescription,
        simulated as simulated,
        with_plugin_joints as with_plugin_joints,
        with_ros2_control_of as with_ros2_control_of,
    )
    from teleopctl.robot.tags.gazebo import (
        OF_JOINTS as OF_JOINTS,
        OF_LINKS as OF_LINKS,
        OF_ROBOTS as OF_ROBOTS,
        of_sensors as of_sensors,
    )
    from teleopctl.robot.tags.table import (
        Table as Table,
        TagFinding as TagFinding,
        gazebo_only_text as gazebo_only_text,
        is_default as is_default,
        local_name as local_name,
        tag_value as tag_value,
    )
    from teleopctl.robot.tags.urdf import unknown_tags as unknown_tags
    from teleopctl.robot.transmissions import (
        DifferentialTransmission as DifferentialTransmission,
        FourBarLinkageTransmission as FourBarLinkageTransmission,
        SimpleTransmission as SimpleTransmission,
        Transmission as Transmission,
        ends_by_role as ends_by_role,
        make_transmission as make_transmission,
        transmission_has_effect as transmission_has_effect,
    )
    from teleopctl.robot.urdf import (
        Box as Box,
        Capsule as Capsule,
        Cylinder as Cylinder,
        Geometry as Geometry,
        Joint as Joint,
        Link as Link,
        Material as Material,
        Mesh as Mesh,
        Mimic as Mimic,
        Pose as Pose,
        Sphere as Sphere,
    )
    from teleopctl.robot.world_file import (
        World as World,
        find_world as find_world,
        is_world as is_world,
        read_world as read_world,
        read_world_text as read_world_text,
    )
    from teleopctl.robot.xacro.expansion import (
        ExpandedXacro as ExpandedXacro,
        bounded_xacro as bounded_xacro,
        expand_xacro as expand_xacro,
        over_budget as over_budget,
        read_xacro as read_xacro,
    )
    from teleopctl.robot.xacro.source_lines import with_source_places as with_source_places
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
