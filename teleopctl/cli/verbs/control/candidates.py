"""What Tab offers for controllers."""

from __future__ import annotations

from teleopctl.errors import TeleopctlError


def controllers(incomplete: str) -> list[str]:
    """Return the names of loaded controllers."""
    from teleopctl.cli.completion.candidates import nodes
    from teleopctl.cli.verbs.control.session import DEFAULT_MANAGER, manager_client

    # Asking takes a moment where nobody answers, so first see whether there is anybody.
    if f"/{DEFAULT_MANAGER}" not in nodes(""):
        return []
    try:
        with manager_client(DEFAULT_MANAGER) as client:
            names = [controller.name for controller in client.list_controllers()]
    except TeleopctlError:
        return []
    return [name for name in names if name.startswith(incomplete)]
