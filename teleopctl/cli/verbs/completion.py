"""``teleopctl completion SHELL``: completion scripts of shells."""

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.completion import shells
from teleopctl.cli.verb import Option, Verb, VerbGroup

GROUP = VerbGroup(
    "Print the completion script of a shell.",
    {
        "bash": Verb(f"{__name__}:bash", 'For bash: eval "$(teleopctl completion bash)"'),
        "zsh": Verb(f"{__name__}:zsh", 'For zsh: eval "$(teleopctl completion zsh)"'),
        "fish": Verb(f"{__name__}:fish", "For fish: teleopctl completion fish | source"),
        "powershell": Verb(
            f"{__name__}:powershell",
            "For PowerShell: teleopctl completion powershell | Out-String | Invoke-Expression",
        ),
    },
)


As = Annotated[
    str,
    Option(
        "--as",
        help="Complete the command under this name, such as ros2.",
        metavar="NAME",
        choices=("teleopctl", "ros2"),
    ),
]


def bash(name: As = "teleopctl") -> None:
    """Print the completion script of bash."""
    console.out_text(shells.script("bash", name))


def zsh(name: As = "teleopctl") -> None:
    """Print the completion script of zsh."""
    console.out_text(shells.script("zsh", name))


def fish(name: As = "teleopctl") -> None:
    """Print the completion script of fish."""
    console.out_text(shells.script("fish", name))


def powershell(name: As = "teleopctl") -> None:
    """Print the completion script of PowerShell."""
    console.out_text(shells.script("powershell", name))
