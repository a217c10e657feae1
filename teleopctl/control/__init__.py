"""ros2_control in Python: hardware components, controllers and the controller manager.

Classes and methods have the names of hardware_interface, controller_interface, controller_manager
and realtime_tools, so that their documentation applies here. A controller derives from
``ControllerInterface``, or from ``ChainableControllerInterface`` if other controllers may command
it, and hardware from ``HardwareComponentInterface``. The manager runs in a process as a
``ControllerManagerNode``; another process calls the manager by a ``ControllerManagerClient``.

May import `base`, `errors`, `interfaces`, `node`, `packages`, `plugins`, `robot` and `tf`.
"""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.control.client import (
        ControllerManagerClient as ControllerManagerClient,
        ControllerManagerUnavailableError as ControllerManagerUnavailableError,
        controller_managers as controller_managers,
        managers_of_same_robot as managers_of_same_robot,
    )
    from teleopctl.control.controller_files import (
        controller_load_parameters as controller_load_parameters,
        parameter_place as parameter_place,
        similar_types as similar_types,
    )
    from teleopctl.control.controller_manager import (
        ControllerManager as ControllerManager,
        ManagerNode as ManagerNode,
    )
    from teleopctl.control.controller_manager_node import (
        ControllerManagerNode as ControllerManagerNode,
    )
    from teleopctl.control.controller_spec import ControllerSpec as ControllerSpec
    from teleopctl.control.controllers.base import (
        ControllerInterface as ControllerInterface,
        ControllerInterfaceParams as ControllerInterfaceParams,
        InterfaceConfiguration as InterfaceConfiguration,
        InterfaceConfigurationType as InterfaceConfigurationType,
    )
    from teleopctl.control.controllers.chainable import (
        ChainableControllerInterface as ChainableControllerInterface,
    )
    from teleopctl.control.controllers.filters.base import (
        FilterBase as FilterBase,
        FilterParams as FilterParams,
        InvalidFilterError as InvalidFilterError,
    )
    from teleopctl.control.controllers.realtime_goal import (
        RealtimeServerGoalHandle as RealtimeServerGoalHandle,
    )
    from teleopctl.control.cycle import Cycle as Cycle, WallClockLoop as WallClockLoop
    from teleopctl.control.handles import (
        ACCELERATION as ACCELERATION,
        EFFORT as EFFORT,
        POSITION as POSITION,
        VELOCITY as VELOCITY,
        CommandInterface as CommandInterface,
        StateInterface as StateInterface,
    )
    from teleopctl.control.hardware.base import (
        HardwareComponentInterface as HardwareComponentInterface,
        HardwareComponentParams as HardwareComponentParams,
    )
    from teleopctl.control.hardware.joint_state_exchange import (
        JOINT_STATE_FIELDS as JOINT_STATE_FIELDS,
        ReceivedJointStates as ReceivedJointStates,
        TopicChannel as TopicChannel,
        replace_topics as replace_topics,
    )
    from teleopctl.control.hardware.transmissions import (
        ActuatorInterfaces as ActuatorInterfaces,
    )
    from teleopctl.control.hardware_component import HardwareComponent as HardwareComponent
    from teleopctl.control.in_memory.control_stack import (
        ControlStack as ControlStack,
    )
    from teleopctl.control.in_memory.recorded_node import (
        RecordedActionServer as RecordedActionServer,
        RecordedEndpoint as RecordedEndpoint,
        RecordedLog as RecordedLog,
        RecordedNode as RecordedNode,
    )
    from teleopctl.control.lifecycle import (
        CallbackReturn as CallbackReturn,
        ReturnType as ReturnType,
        State as State,
    )
    from teleopctl.control.limits import command_ranges as command_ranges
    from teleopctl.control.realtime_publisher import (
        PublishQueue as PublishQueue,
        RealtimePublisher as RealtimePublisher,
    )
    from teleopctl.control.resource_manager import (
        ClaimError as ClaimError,
        ResourceManager as ResourceManager,
    )
    from teleopctl.control.services import ControllerManagerServices as ControllerManagerServices
    from teleopctl.control.switching import (
        Strictness as Strictness,
        SwitchRequest as SwitchRequest,
        switch_controller as switch_controller,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
