"""``teleopctl completion SHELL``: completion scripts of shells."""

from __future__ import annotations

from teleopctl.cli import console
from teleopctl.cli.completion import shells
from teleopctl.cli.verb import Verb, VerbGroup

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


def bash() -> None:
    """Print the completion script of bash."""
    console.out_text(shells.BASH)


def zsh() -> None:
    """Print the completion script of zsh."""
    console.out_text(shells.ZSH)


def fish() -> None:
    """Print the completion script of fish."""
    console.out_text(shells.FISH)


def powershell() -> None:
    """Print the completion script of PowerShell."""
    console.out_text(shells.POWERSHELL)
