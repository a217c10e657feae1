"""``teleopctl param``: one module per subject, imported when one of its verbs runs."""

from __future__ import annotations

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "Read and change parameters of nodes.",
    {
        "list": Verb(f"{__name__}.reading:list_parameters", "List parameters."),
        "get": Verb(f"{__name__}.reading:get_parameter", "Print the values of parameters."),
        "set": Verb(
            f"{__name__}.writing:set_parameter",
            "Change parameters.",
            negative_numbers=True,
            examples=("teleopctl param set /simple_parameter simple_int_param 24",),
        ),
        "delete": Verb(f"{__name__}.writing:delete_parameter", "Delete a parameter."),
        "describe": Verb(f"{__name__}.reading:describe_parameters", "Describe parameters."),
        "dump": Verb(f"{__name__}.writing:dump_parameters", "Print a node's parameters as a file."),
        "load": Verb(f"{__name__}.writing:load_parameters", "Set parameters from a file."),
        "save": Verb(
            f"{__name__}.writing:save_parameters",
            "Write the parameters of nodes to a file.",
            examples=(
                "teleopctl param save parameters.yaml",
                "teleopctl param restore parameters.yaml",
            ),
        ),
        "restore": Verb(
            f"{__name__}.writing:restore_parameters", "Set the parameters of nodes from a file."
        ),
    },
    leaves_nothing=True,
)
