"""Launch files of ROS 2: reading, evaluation, and supervision of the processes.

A front end reads a file (`frontends`) into steps with actions (`actions`, over `model`). With the
launch arguments, the steps are evaluated into a plan of processes, timers and event handlers
(`evaluation`). The plan is executed (`execution`) in the foreground or, through ``python -m
teleopctl.launch``, in the background; on each event the evaluation returns the next steps.

A custom action derives from ``Action``, a custom substitution is a ``Substitution``.

May import `interfaces`, `node`, `robot` and `wire`, and what every package may: `base`, `errors`,
`packages` and `plugins`.
"""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.launch.actions.components import (
        LoadComponents as LoadComponents,
    )
    from teleopctl.launch.actions.environment import (
        AppendEnvironment as AppendEnvironment,
        PopEnvironment as PopEnvironment,
        PushEnvironment as PushEnvironment,
        ReplaceEnvironment as ReplaceEnvironment,
        ResetEnvironment as ResetEnvironment,
        SetEnvironment as SetEnvironment,
        SetRosLogDirectory as SetRosLogDirectory,
        UnsetEnvironment as UnsetEnvironment,
    )
    from teleopctl.launch.actions.gazebo import (
        GzServer as GzServer,
        GzSpawnModel as GzSpawnModel,
        RosGzBridge as RosGzBridge,
    )
    from teleopctl.launch.actions.messages import (
        Log as Log,
        Shutdown as Shutdown,
    )
    from teleopctl.launch.actions.nesting import (
        Group as Group,
        Include as Include,
        IncludeSteps as IncludeSteps,
        TimedEntities as TimedEntities,
    )
    from teleopctl.launch.actions.process import (
        Executable as Executable,
        Node as Node,
    )
    from teleopctl.launch.actions.ros_timer import (
        RosTimer as RosTimer,
    )
    from teleopctl.launch.actions.settings import (
        DeclareArgument as DeclareArgument,
        DeclareBoolean as DeclareBoolean,
        Let as Let,
        PopConfigurations as PopConfigurations,
        PushConfigurations as PushConfigurations,
        PushNamespace as PushNamespace,
        Reset as Reset,
        SetParameter as SetParameter,
        SetParametersFromFile as SetParametersFromFile,
        SetRemap as SetRemap,
        SetUseSimTime as SetUseSimTime,
        Unset as Unset,
    )
    from teleopctl.launch.arguments import (
        argument_names as argument_names,
        describe_arguments as describe_arguments,
        undeclared_argument_warnings as undeclared_argument_warnings,
    )
    from teleopctl.launch.evaluation.context import (
        LaunchContext as LaunchContext,
    )
    from teleopctl.launch.evaluation.evaluation import (
        DryRun as DryRun,
        Evaluation as Evaluation,
    )
    from teleopctl.launch.evaluation.parameters import (
        parameter_value as parameter_value,
    )
    from teleopctl.launch.evaluation.processes import (
        ProcessBuilder as ProcessBuilder,
    )
    from teleopctl.launch.evaluation.robot_substitutions import (
        chosen_controllers as chosen_controllers,
    )
    from teleopctl.launch.evaluation.substitution import (
        Substitution as Substitution,
    )
    from teleopctl.launch.execution.judgement import (
        addresses as addresses,
        log_tail as log_tail,
    )
    from teleopctl.launch.execution.readiness import (
        NewNodes as NewNodes,
        wait_for_node as wait_for_node,
    )
    from teleopctl.launch.execution.running import (
        Running as Running,
        died as died,
        duration as duration,
        find_running as find_running,
        forget_died as forget_died,
        how_to_stop as how_to_stop,
        newest_log as newest_log,
        running as running,
        started_in_background as started_in_background,
        stop_running as stop_running,
    )
    from teleopctl.launch.execution.screen import (
        LOG_FORMAT as LOG_FORMAT,
        SCREEN_FORMAT as SCREEN_FORMAT,
    )
    from teleopctl.launch.execution.standby import (
        standby_simulator as standby_simulator,
    )
    from teleopctl.launch.execution.status import (
        ProcessStatus as ProcessStatus,
        command_text as command_text,
        folder_of as folder_of,
        mark_stopped as mark_stopped,
    )
    from teleopctl.launch.execution.supervisor import (
        Supervisor as Supervisor,
    )
    from teleopctl.launch.finding import (
        builtin_files as builtin_files,
        files_in_package as files_in_package,
        find_launch_file as find_launch_file,
        is_builtin as is_builtin,
        is_launch_file as is_launch_file,
    )
    from teleopctl.launch.frontends import (
        parse_text as parse_text,
        read_launch_file as read_launch_file,
    )
    from teleopctl.launch.frontends.steps import (
        read_step as read_step,
    )
    from teleopctl.launch.model.action import (
        Action as Action,
        Entity as Entity,
        Handler as Handler,
        Launch as Launch,
        LaunchFile as LaunchFile,
        Step as Step,
        exposed_actions as exposed_actions,
        exposed_substitutions as exposed_substitutions,
        load_launch_extensions as load_launch_extensions,
    )
    from teleopctl.launch.model.descriptions import (
        ComponentPart as ComponentPart,
        Condition as Condition,
        NodePart as NodePart,
        ParameterEntry as ParameterEntry,
        ParameterFileEntry as ParameterFileEntry,
        ParameterTree as ParameterTree,
        Place as Place,
        ProcessPart as ProcessPart,
    )
    from teleopctl.launch.model.element import (
        Element as Element,
    )
    from teleopctl.launch.model.events import (
        ProcessEvent as ProcessEvent,
        ProcessExited as ProcessExited,
        ProcessOutput as ProcessOutput,
        ProcessStarted as ProcessStarted,
        ShutdownBegan as ShutdownBegan,
        SignalRequested as SignalRequested,
    )
    from teleopctl.launch.model.output import (
        output_alias as output_alias,
        output_table as output_table,
    )
    from teleopctl.launch.model.plan import (
        FollowUp as FollowUp,
        LaunchPlan as LaunchPlan,
        ProcessPlan as ProcessPlan,
    )
    from teleopctl.launch.model.records import dataclass as dataclass
    from teleopctl.launch.model.request import (
        LaunchRequest as LaunchRequest,
    )
    from teleopctl.launch.model.template import (
        Call as Call,
        ComputedText as ComputedText,
        SubstitutionArgument as SubstitutionArgument,
        Template as Template,
        literal as literal,
    )
    from teleopctl.launch.model.values import (
        boolean as boolean,
        flag as flag,
        split_command_line as split_command_line,
    )
    from teleopctl.launch.recording import (
        RECORDER as RECORDER,
        bag_folder as bag_folder,
        with_recorder as with_recorder,
    )
    from teleopctl.launch.service_calls import (
        CallSequence as CallSequence,
    )
    from teleopctl.launch.starting import (
        current_log_directory as current_log_directory,
        evaluate_request as evaluate_request,
        launch_name as launch_name,
        new_log_directory as new_log_directory,
        prepare as prepare,
        run_here as run_here,
        start_in_background as start_in_background,
        take_temporary_files as take_temporary_files,
        unused_launch_name as unused_launch_name,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
