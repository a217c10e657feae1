"""ROS client library with rclpy's names: nodes, publishers, subscriptions, services, actions.

Each name is imported when it is first used, so that importing this package takes no time.

May import `interfaces` and `wire`, and what every package may: `base`, `errors`, `packages` and
`plugins`.
"""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.node.actions.client import (
        ActionClient as ActionClient,
        ClientGoalHandle as ClientGoalHandle,
    )
    from teleopctl.node.actions.goal_state import (
        GoalEvent as GoalEvent,
        GoalState as GoalState,
        InvalidGoalTransitionError as InvalidGoalTransitionError,
    )
    from teleopctl.node.actions.server import (
        AcceptedCallback as AcceptedCallback,
        ActionServer as ActionServer,
        CancelCallback as CancelCallback,
        CancelResponse as CancelResponse,
        GoalCallback as GoalCallback,
        GoalResponse as GoalResponse,
        default_cancel_callback as default_cancel_callback,
        default_goal_callback as default_goal_callback,
        default_handle_accepted_callback as default_handle_accepted_callback,
    )
    from teleopctl.node.actions.server_goal import ServerGoalHandle as ServerGoalHandle
    from teleopctl.node.clock import (
        Clock as Clock,
        ClockChange as ClockChange,
        JumpHandle as JumpHandle,
        JumpThreshold as JumpThreshold,
        ROSClock as ROSClock,
        TimeJump as TimeJump,
    )
    from teleopctl.node.command_lease import (
        LEASE_TOPIC as LEASE_TOPIC,
        LEASE_TYPE as LEASE_TYPE,
        LeaseHolder as LeaseHolder,
        LeaseWatch as LeaseWatch,
    )
    from teleopctl.node.context import Context as Context
    from teleopctl.node.endpoints.client import Client as Client, ResponseFuture as ResponseFuture
    from teleopctl.node.endpoints.events import (
        DeadlineMissedInfo as DeadlineMissedInfo,
        IncompatibleQoSInfo as IncompatibleQoSInfo,
        IncompatibleTypeInfo as IncompatibleTypeInfo,
        LivelinessChangedInfo as LivelinessChangedInfo,
        LivelinessLostInfo as LivelinessLostInfo,
        MatchedInfo as MatchedInfo,
        MessageLostInfo as MessageLostInfo,
        PublisherEventCallbacks as PublisherEventCallbacks,
        SubscriptionEventCallbacks as SubscriptionEventCallbacks,
        UnsupportedEventTypeError as UnsupportedEventTypeError,
    )
    from teleopctl.node.endpoints.guard_condition import GuardCondition as GuardCondition
    from teleopctl.node.endpoints.publisher import Publisher as Publisher
    from teleopctl.node.endpoints.qos_overrides import (
        InvalidQosOverridesError as InvalidQosOverridesError,
        QoSOverridingOptions as QoSOverridingOptions,
        QoSPolicyKind as QoSPolicyKind,
    )
    from teleopctl.node.endpoints.service import Service as Service
    from teleopctl.node.endpoints.service_introspection import (
        ServiceIntrospectionState as ServiceIntrospectionState,
    )
    from teleopctl.node.endpoints.subscription import (
        ContentFilterOptions as ContentFilterOptions,
        MessageInfo as MessageInfo,
        Subscription as Subscription,
        SubscriptionHandle as SubscriptionHandle,
    )
    from teleopctl.node.endpoints.timer import Rate as Rate, Timer as Timer
    from teleopctl.node.endpoints.topic_statistics import (
        TopicStatisticsOptions as TopicStatisticsOptions,
    )
    from teleopctl.node.endpoints.waitable import NumberOfEntities as NumberOfEntities
    from teleopctl.node.executors import (
        Executor as Executor,
        MultiThreadedExecutor as MultiThreadedExecutor,
        SingleThreadedExecutor as SingleThreadedExecutor,
    )
    from teleopctl.node.generic_subscription import (
        add_type_from_graph as add_type_from_graph,
        create_generic_subscription as create_generic_subscription,
        qos_for_publishers as qos_for_publishers,
        raw_message_class as raw_message_class,
        request_type_description as request_type_description,
    )
    from teleopctl.node.graph_view import (
        get_action_client_names_and_types_by_node as get_action_client_names_and_types_by_node,
        get_action_names_and_types as get_action_names_and_types,
        get_action_server_names_and_types_by_node as get_action_server_names_and_types_by_node,
    )
    from teleopctl.node.lifecycle.managed_entity import (
        LifecyclePublisher as LifecyclePublisher,
        ManagedEntity as ManagedEntity,
        SimpleManagedEntity as SimpleManagedEntity,
    )
    from teleopctl.node.lifecycle.node import (
        LifecycleNode as LifecycleNode,
        LifecycleNodeMixin as LifecycleNodeMixin,
    )
    from teleopctl.node.lifecycle.services import LifecycleStateMachine as LifecycleStateMachine
    from teleopctl.node.lifecycle.states import (
        LifecycleState as LifecycleState,
        PrimaryState as PrimaryState,
        TransitionCallbackReturn as TransitionCallbackReturn,
        TransitionNotPossibleError as TransitionNotPossibleError,
    )
    from teleopctl.node.lifetime import (
        create_node as create_node,
        get_default_context as get_default_context,
        get_global_executor as get_global_executor,
        init as init,
        ok as ok,
        open_node as open_node,
        shutdown as shutdown,
        spin as spin,
        spin_in_thread as spin_in_thread,
        spin_once as spin_once,
        spin_until_future_complete as spin_until_future_complete,
        try_shutdown as try_shutdown,
    )
    from teleopctl.node.newest_message import NewestMessage as NewestMessage
    from teleopctl.node.node import Node as Node
    from teleopctl.node.node_endpoints import BareNode as BareNode
    from teleopctl.node.node_options import NodeOptions as NodeOptions
    from teleopctl.node.node_services import (
        LoggerService as LoggerService,
        start_type_description_service as start_type_description_service,
    )
    from teleopctl.node.parameters.client import (
        AsyncParameterClient as AsyncParameterClient,
        call_parameter_services as call_parameter_services,
    )
    from teleopctl.node.parameters.events import (
        ParameterCallbackHandle as ParameterCallbackHandle,
        ParameterEventCallbackHandle as ParameterEventCallbackHandle,
        ParameterEventHandler as ParameterEventHandler,
    )
    from teleopctl.node.parameters.service import ParameterService as ParameterService
    from teleopctl.node.robot_stop import (
        RELEASE_SERVICE as RELEASE_SERVICE,
        RELEASE_TYPE as RELEASE_TYPE,
        STOP_TOPIC as STOP_TOPIC,
        StopButton as StopButton,
        StopHolders as StopHolders,
    )
    from teleopctl.node.topic_meter import TopicMeter as TopicMeter, Traffic as Traffic
    from teleopctl.node.user_waitable import Waitable as Waitable
    from teleopctl.node.values.callback_groups import (
        CallbackGroup as CallbackGroup,
        MutuallyExclusiveCallbackGroup as MutuallyExclusiveCallbackGroup,
        ReentrantCallbackGroup as ReentrantCallbackGroup,
    )
    from teleopctl.node.values.command_lease import (
        SILENCE_S as SILENCE_S,
        STREAM_FRAME as STREAM_FRAME,
        CommandLease as CommandLease,
        LeaseClaim as LeaseClaim,
    )
    from teleopctl.node.values.endpoint_info import (
        TopicEndpointInfo as TopicEndpointInfo,
        TopicEndpointTypeEnum as TopicEndpointTypeEnum,
        TypeHash as TypeHash,
    )
    from teleopctl.node.values.exceptions import (
        ConditionReachedException as ConditionReachedException,
        ExternalShutdownException as ExternalShutdownException,
        InvalidHandle as InvalidHandle,
        InvalidNamespaceException as InvalidNamespaceException,
        InvalidNodeNameException as InvalidNodeNameException,
        InvalidParameterException as InvalidParameterException,
        InvalidParameterTypeException as InvalidParameterTypeException,
        InvalidParameterValueException as InvalidParameterValueException,
        InvalidServiceNameException as InvalidServiceNameException,
        InvalidTopicNameException as InvalidTopicNameException,
        NameValidationException as NameValidationException,
        NodeNameNonExistentError as NodeNameNonExistentError,
        NotInitializedException as NotInitializedException,
        ParameterAlreadyDeclaredException as ParameterAlreadyDeclaredException,
        ParameterException as ParameterException,
        ParameterImmutableException as ParameterImmutableException,
        ParameterNotDeclaredException as ParameterNotDeclaredException,
        ParameterUninitializedException as ParameterUninitializedException,
        RCLError as RCLError,
        ROSInterruptException as ROSInterruptException,
        ServiceUnavailableError as ServiceUnavailableError,
        ShutdownException as ShutdownException,
        TimeoutException as TimeoutException,
        TimerCancelledError as TimerCancelledError,
    )
    from teleopctl.node.values.future import (
        AnyFuture as AnyFuture,
        Future as Future,
        Task as Task,
    )
    from teleopctl.node.values.handle import Handle as Handle
    from teleopctl.node.values.log_once import LogOnce as LogOnce
    from teleopctl.node.values.logging import (
        Caller as Caller,
        LoggingSeverity as LoggingSeverity,
        RcutilsLogger as RcutilsLogger,
        effective_level as effective_level,
        emit_log as emit_log,
        get_logger as get_logger,
        get_logger_level as get_logger_level,
        reset_levels as reset_levels,
        set_logger_level as set_logger_level,
        severity_from_name as severity_from_name,
    )
    from teleopctl.node.values.names import (
        absolute_namespace as absolute_namespace,
        expand_name as expand_name,
        expand_unchecked as expand_unchecked,
        validate_absolute_name as validate_absolute_name,
        validate_name as validate_name,
        validate_namespace as validate_namespace,
        validate_node_name as validate_node_name,
    )
    from teleopctl.node.values.parameter import (
        Parameter as Parameter,
        ParameterType as ParameterType,
        parameter_value_from_yaml as parameter_value_from_yaml,
        parameter_value_problem as parameter_value_problem,
    )
    from teleopctl.node.values.parameter_file import (
        ParameterFile as ParameterFile,
        copy_mark as copy_mark,
        find_parameter_line as find_parameter_line,
        flatten_parameters as flatten_parameters,
        parameter_document as parameter_document,
        parameter_messages as parameter_messages,
        place_in_file as place_in_file,
        plain_parameter_value as plain_parameter_value,
        read_parameter_file as read_parameter_file,
        read_parameter_lines as read_parameter_lines,
    )
    from teleopctl.node.values.qos import (
        BEST_AVAILABLE_NS as BEST_AVAILABLE_NS,
        DurabilityPolicy as DurabilityPolicy,
        HistoryPolicy as HistoryPolicy,
        InvalidQoSProfileException as InvalidQoSProfileException,
        LivelinessPolicy as LivelinessPolicy,
        QoSCompatibility as QoSCompatibility,
        QoSPolicyEnum as QoSPolicyEnum,
        QoSPresetProfiles as QoSPresetProfiles,
        QoSProfile as QoSProfile,
        ReliabilityPolicy as ReliabilityPolicy,
        qos_check_compatible as qos_check_compatible,
        qos_profile_action_status_default as qos_profile_action_status_default,
        qos_profile_best_available as qos_profile_best_available,
        qos_profile_default as qos_profile_default,
        qos_profile_latched as qos_profile_latched,
        qos_profile_parameter_events as qos_profile_parameter_events,
        qos_profile_parameters as qos_profile_parameters,
        qos_profile_rosout_default as qos_profile_rosout_default,
        qos_profile_sensor_data as qos_profile_sensor_data,
        qos_profile_services_default as qos_profile_services_default,
        qos_profile_system_default as qos_profile_system_default,
        qos_profile_unknown as qos_profile_unknown,
    )
    from teleopctl.node.values.ros_args import parse_ros_arguments as parse_ros_arguments
    from teleopctl.node.values.signals import (
        SignalHandlerOptions as SignalHandlerOptions,
        get_current_signal_handlers_options as get_current_signal_handlers_options,
        install_for_all_contexts as install_for_all_contexts,
        uninstall_for_all_contexts as uninstall_for_all_contexts,
    )
    from teleopctl.node.values.time import (
        ClockType as ClockType,
        Duration as Duration,
        Infinite as Infinite,
        Time as Time,
    )
    from teleopctl.node.wait_set import (
        EventHandle as EventHandle,
        GuardHandle as GuardHandle,
        WaitSet as WaitSet,
        create_polled_client as create_polled_client,
        create_polled_service as create_polled_service,
        create_polled_subscription as create_polled_subscription,
        create_polled_timer as create_polled_timer,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
