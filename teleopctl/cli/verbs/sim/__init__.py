"""``teleopctl sim``: the simulation that runs, and many of them."""

from teleopctl.cli.verb import Group, Verb

_RUNNING = f"{__name__}.running"

GROUP = Group(
    "Run simulations.",
    {
        "pause": Verb(f"{_RUNNING}:pause", "Let simulated time stand still."),
        "play": Verb(f"{_RUNNING}:play", "Let simulated time go on."),
        "step": Verb(f"{_RUNNING}:step", "Advance a paused simulation by steps of physics."),
        "reset": Verb(f"{_RUNNING}:reset", "Go back to the start."),
        "list": Verb(f"{_RUNNING}:list_entities", "List robots and things of the simulation."),
        "spawn": Verb(
            f"{_RUNNING}:spawn",
            "Put a thing into the simulation.",
            examples=("teleopctl sim spawn can.urdf --at 0.3,1.2,0.5",),
        ),
        "delete": Verb(f"{_RUNNING}:delete", "Take a thing out of the simulation."),
        "save": Verb(
            f"{_RUNNING}:save",
            "Save the state of the simulation.",
            examples=("teleopctl sim save grasp", "teleopctl sim save grasp.json"),
        ),
        "load": Verb(f"{_RUNNING}:load", "Go on from a saved state."),
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
