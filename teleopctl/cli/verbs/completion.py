"""``teleopctl completion SHELL``: the script that makes the shell ask us on Tab."""

from __future__ import annotations

import os

from teleopctl.cli import console
from teleopctl.cli.console import COMPLETION_VARIABLE, PROGRAM
from teleopctl.cli.verb import Group, Verb

GROUP = Group(
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


_BASH = """_teleopctl_completion() {{
    local IFS=$'\\n'
    COMPREPLY=( $( COMP_WORDS="${{COMP_WORDS[*]}}" COMP_CWORD=$COMP_CWORD \\
        {variable}=complete_bash $1 ) )
    # Behind NAME:= the value follows at once.
    [[ ${{COMPREPLY[0]}} == *:= ]] && compopt -o nospace
    return 0
}}

complete -o default -F _teleopctl_completion {program}"""


def bash() -> None:
    """Print bash's script."""
    console.out_text(_BASH.format(variable=COMPLETION_VARIABLE, program=PROGRAM))


def zsh() -> None:
    """Print zsh's script."""
    _print_script("zsh")


def fish() -> None:
    """Print fish's script."""
    _print_script("fish")


def powershell() -> None:
    """Print PowerShell's script."""
    _print_script("powershell")


def _print_script(shell: str) -> None:
    from teleopctl.cli import typer_app

    os.environ[COMPLETION_VARIABLE] = f"source_{shell}"
    typer_app.answer_shell(["completion"])
