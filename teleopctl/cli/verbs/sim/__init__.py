"""``teleopctl sim``: simulations as a whole."""

from teleopctl.cli.verb import Group, Verb

_HERE = __name__

GROUP = Group(
    "Run simulations.",
    {
        "sweep": Verb(
            f"{_HERE}.sweep:sweep",
            "Run a launch file many times with varied parameters.",
            examples=(
                "teleopctl sim sweep sim.yaml camera:=false --grid mujoco_sim:mass_scale:=0.5,1,2 "
                "--duration 10 --measure '/joint_states/position[0]:max'",
                "teleopctl sim sweep --resume runs",
            ),
        )
    },
)
