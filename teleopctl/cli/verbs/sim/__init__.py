"""``teleopctl sim``: the simulation that runs, and many of them."""

from teleopctl.cli.verb import Verb, VerbGroup

_RUNNING = f"{__name__}.running"

GROUP = VerbGroup(
    "Run simulations.",
    {
        "pause": Verb(f"{_RUNNING}:pause", "Pause the simulation."),
        "play": Verb(f"{_RUNNING}:play", "Resume the simulation."),
        "step": Verb(f"{_RUNNING}:step", "Advance a paused simulation by steps of physics."),
        "reset": Verb(f"{_RUNNING}:reset", "Reset the simulation."),
        "list": Verb(f"{_RUNNING}:list_entities", "List the entities of the simulation."),
        "spawn": Verb(
            f"{_RUNNING}:spawn",
            "Add an object to the simulation.",
            examples=("teleopctl sim spawn can.urdf --at 0.3,1.2,0.5",),
        ),
        "delete": Verb(f"{_RUNNING}:delete", "Remove an entity from the simulation."),
        "save": Verb(
            f"{_RUNNING}:save",
            "Save the state of the simulation.",
            examples=("teleopctl sim save grasp", "teleopctl sim save grasp.json"),
        ),
        "load": Verb(f"{_RUNNING}:load", "Load a saved state."),
        "sweep": Verb(
            f"{__name__}.sweep:sweep",
            "Run a launch file many times with varied parameters.",
            examples=(
                "teleopctl sim sweep sim.yaml camera:=false --grid mujoco_sim:mass_scale:=0.5,1,2 "
                "--duration 10 --measure '/joint_states/position[0]:max'",
                "teleopctl sim sweep --resume runs",
            ),
        ),
    },
)
