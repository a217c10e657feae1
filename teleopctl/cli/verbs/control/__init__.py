"""``teleopctl control``: the verbs of ``ros2 control``, for controllers and hardware."""

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "Manage controllers and hardware.",
    {
        "list_controllers": Verb(
            f"{__name__}.controllers:list_controllers", "List loaded controllers and their states."
        ),
        "list_controller_types": Verb(
            f"{__name__}.controllers:list_controller_types",
            "List the controller types that can be loaded.",
        ),
        "list_hardware_components": Verb(
            f"{__name__}.hardware:list_hardware_components", "List hardware and its states."
        ),
        "list_hardware_interfaces": Verb(
            f"{__name__}.hardware:list_hardware_interfaces",
            "List the command and state interfaces of the hardware.",
        ),
        "load_controller": Verb(f"{__name__}.controllers:load_controller", "Load a controller."),
        "unload_controller": Verb(
            f"{__name__}.controllers:unload_controller", "Unload a controller."
        ),
        "cleanup_controller": Verb(
            f"{__name__}.controllers:cleanup_controller", "Bring a controller back to unconfigured."
        ),
        "set_controller_state": Verb(
            f"{__name__}.controllers:set_controller_state", "Bring a controller to a state."
        ),
        "switch_controllers": Verb(
            f"{__name__}.controllers:switch_controllers",
            "Stop and start controllers in one switch.",
        ),
        "set_hardware_component_state": Verb(
            f"{__name__}.hardware:set_hardware_component_state",
            "Bring a hardware component to a state.",
        ),
        "reload_controller_libraries": Verb(
            f"{__name__}.controllers:reload_controller_libraries",
            "Unload all controllers and their code.",
        ),
        "reload": Verb(
            f"{__name__}.reloading:reload",
            "Run a controller's changed code without stopping it.",
        ),
        "doctor": Verb(
            f"{__name__}.doctor:doctor",
            "Find what keeps controllers from activation or joints from motion.",
            examples=("teleopctl control doctor", "teleopctl control doctor arm_controller"),
        ),
        "plot": Verb(
            f"{__name__}.plot:plot",
            "Draw reference, feedback and error of a trajectory controller.",
            examples=(
                "teleopctl control plot arm_controller --window 3",
                "teleopctl control plot arm_controller --joints joint_1,joint_2 -o arm.svg",
            ),
        ),
        "view_controller_chains": Verb(
            f"{__name__}.controllers:view_controller_chains",
            "Draw controllers and their interfaces.",
        ),
        "top": Verb(
            f"{__name__}.top:top",
            "Watch rates and execution times of controllers and hardware.",
            examples=("teleopctl control top", "teleopctl control top --once --json"),
        ),
        "view_hardware_status": Verb(
            f"{__name__}.hardware:view_hardware_status",
            "Print the status that hardware reports.",
        ),
    },
    leaves_nothing=True,
)
