"""``controller_manager``: the part that launch files and launch tests use."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from controller_manager.controller_manager_services import (
        bcolors as bcolors,
        cleanup_controller as cleanup_controller,
        configure_controller as configure_controller,
        get_parameter_from_param_files as get_parameter_from_param_files,
        list_controller_types as list_controller_types,
        list_controllers as list_controllers,
        list_hardware_components as list_hardware_components,
        list_hardware_interfaces as list_hardware_interfaces,
        load_controller as load_controller,
        reload_controller_libraries as reload_controller_libraries,
        set_controller_parameters as set_controller_parameters,
        set_controller_parameters_from_param_files as set_controller_parameters_from_param_files,
        set_hardware_component_state as set_hardware_component_state,
        switch_controllers as switch_controllers,
        unload_controller as unload_controller,
    )
else:
    from teleopctl.base.lazy import attach

    # Launch files use `launch_utils` alone, and need no rclpy for that.
    __getattr__, __dir__, __all__ = attach()
