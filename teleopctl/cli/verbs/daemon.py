"""``teleopctl daemon``: the Zenoh router through which nodes discover each other."""

import sys

from teleopctl.base.printable import printable_line
from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option, Verb, VerbGroup
from teleopctl.errors import RefusedError

if TYPE_CHECKING:
    from teleopctl.wire import RouterAddress, RouterReach

GROUP = VerbGroup(
    "Manage the router through which nodes discover each other.",
    {
        "start": Verb(f"{__name__}:start", "Start the daemon if it is not running."),
        "stop": Verb(f"{__name__}:stop", "Stop the daemon if it is running."),
        "status": Verb(
            f"{__name__}:status", "Print whether the daemon is running, and its addresses."
        ),
    },
    leaves_nothing=True,
)


def start(
    debug: Annotated[
        bool,
        Option(
            "-d",
            "--debug",
            help="Run the daemon in the foreground until Ctrl-C, and show Zenoh's log.",
        ),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Start the router daemon if it is not running; with ``debug`` in the foreground."""
    from teleopctl.wire import (
        daemon_address,
        router_reach,
        run_daemon,
        session_config,
        start_router,
    )

    if debug:
        if not run_daemon(when_up=_print_reach):
            console.out("The daemon is already running")
        return
    started = start_router()
    address, sessions = daemon_address(), session_config("client").router
    reach = router_reach(address)
    if as_json:
        fields = {"endpoint": address.text, "sessions": sessions.text, **_fields(reach)}
        console.out_json({"started": started, **fields})
        return
    console.out("The daemon has been started" if started else "The daemon is already running")
    if address.is_missed_by(sessions):
        _print_endpoints(address, sessions)
    _print_reach(reach)


def stop(
    yes: Annotated[bool, Option("-y", "--yes", help="Stop it under running launches too.")] = False,
    as_json: AsJson = False,
) -> None:
    """Stop the router daemon if it is running.

    Unlike ROS 2's daemon, it connects the nodes: asks on a terminal while launches run.
    """
    from teleopctl.base import background
    from teleopctl.wire import daemon_address, find_router, stop_router

    if not yes and find_router() is not None:
        launches = [each for each in background.records() if each.kind == background.LAUNCH]
        launches += background.foreground_launches()
        if launches and not _agreed([each.name for each in launches]):
            return
    stopped = stop_router()
    if as_json:
        console.out_json({"stopped": stopped, "endpoint": daemon_address().text})
    else:
        console.out("The daemon has been stopped" if stopped else "The daemon is not running")


def _agreed(launches: list[str]) -> bool:
    """Prompt the user on the terminal whether to stop the router; return the answer.

    Raises:
        RefusedError: Stdin or stderr is not a terminal.
    """
    what = f"{', '.join(launches)} would lose the router, through which nodes discover each other"
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise RefusedError(
            what,
            hint="`teleopctl stop` ends what runs; `teleopctl daemon stop --yes` the router alone.",
        )
    sys.stderr.write(f"{printable_line(what)}. Stop it? [y/N] ")
    sys.stderr.flush()
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def status(as_json: AsJson = False) -> None:
    """Print whether the router daemon is running, and its addresses."""
    from teleopctl.wire import (
        RouterNotRunning,
        daemon_address,
        find_router,
        router_reach,
        session_config,
    )

    address, sessions = daemon_address(), session_config("client").router
    try:
        reach = router_reach(address)
    except RouterNotRunning:
        reach = None
    running = reach is not None
    # A router that teleopctl did not start, such as rmw_zenohd, has no record.
    record = find_router(address) if running else None
    if as_json:
        console.out_json(
            {
                "running": running,
                "endpoint": address.text,
                "sessions": sessions.text,
                "pid": record.pid if record else None,
                "log_file": str(record.log_file) if record else None,
                **_fields(reach),
            }
        )
        return
    console.out("The daemon is running" if running else "The daemon is not running")
    _print_endpoints(address, sessions)
    if reach is not None:
        _print_reach(reach)
    if record is not None:
        console.note(f"Process: {record.pid}")
        console.note(f"Log file: {record.log_file}")


def _fields(reach: "RouterReach | None") -> dict[str, list[str]]:
    return {
        "listens": list(reach.addresses) if reach else [],
        "open_to_others": list(reach.beyond) if reach else [],
    }


def _print_reach(reach: "RouterReach") -> None:
    """Print where the router listens, and a warning if other machines can reach it."""
    if reach.danger is not None:
        from teleopctl.wire import HOW_TO_CLOSE

        console.warn(f"{reach.danger}\n  {HOW_TO_CLOSE}")
    else:
        listens = ", ".join(reach.addresses)
        console.note(f"Listens at: {listens} (this machine only, without authentication)")


def _print_endpoints(address: "RouterAddress", sessions: "RouterAddress") -> None:
    """Print the endpoints to stderr: scripts read the one line of ROS 2, or --json."""
    console.note(f"Endpoint: {address.text}")
    if address.is_missed_by(sessions):
        console.note(f"Sessions connect elsewhere: {sessions}")
