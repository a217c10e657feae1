"""``teleopctl stop``: ends what runs in the background."""

import sys
from collections.abc import Iterator, Sequence

from teleopctl.base.printable import printable_line
from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option, Verb
from teleopctl.errors import NotFoundError, TeleopctlError, UsageError
from teleopctl.launch import (
    Running,
    died,
    find_running,
    folder_of,
    forget_died,
    log_tail,
    mark_stopped,
    running,
    stop_running,
)

VERB = Verb(
    f"{__name__}:stop",
    "End background processes, or stop the robot's motion.",
    examples=(
        "teleopctl stop --all",
        "teleopctl stop /talker",
        "teleopctl stop --robot",
        "teleopctl stop --robot --release",
    ),
)


def stop(
    names: Annotated[
        list[str] | None,
        Argument(
            metavar="NAME",
            help="Names as in `teleopctl ps`, or nodes, wherever they were started; without any, "
            "all background processes stop after a prompt.",
            complete="running_processes",
        ),
    ] = None,
    everything: Annotated[
        bool, Option("--all", help="Stop every node and launch, and then the router.")
    ] = False,
    yes: Annotated[
        bool, Option("-y", "--yes", help="Stop every node and launch, without asking.")
    ] = False,
    robot: Annotated[
        bool,
        Option(
            "--robot",
            help="Stop the robot's motion: controllers decelerate, and refuse commands.",
        ),
    ] = False,
    release: Annotated[
        bool, Option("--release", help="With --robot: release the robot again.")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """End background processes: SIGINT, after 5 s SIGTERM, after 5 s more SIGKILL.

    Processes that have died are reported once, with the end of their log unless it was shown
    before. With ``--robot`` all processes go on, and every controller manager brings its joints to
    rest; this is no safety function.
    """
    if robot:
        if names or everything or yes:
            raise UsageError("--robot stops the robot's motion, and takes no names, --all or --yes")
        from teleopctl.cli.verbs.stop.robot import release_robot, stop_robot

        return release_robot(as_json) if release else stop_robot(as_json)
    if release:
        raise UsageError("--release releases a stopped robot: `teleopctl stop --robot --release`")
    gone = [entry for entry in died() if not names or _names_of(entry) & set(names)]
    if names:
        told = {name for entry in gone for name in _names_of(entry)}
        chosen = list(dict.fromkeys(e for name in names for e in _found(name, told)))
    else:
        chosen = [entry for entry in running() if entry.launch is None]
        if not everything:
            chosen = [entry for entry in chosen if entry.record.kind != "router"]
            if chosen and not yes and not _agreed(chosen):
                console.note("Nothing has been stopped.")
                return 1
    for entry in gone:
        if entry.is_death_shown:
            console.warn(f"{entry.qualified_name} {entry.ending}, as reported before")
            continue
        console.warn(f"{entry.qualified_name} {entry.ending}; its last lines:")
        console.note(log_tail(entry.record.log_file))
    if not chosen and not gone and not as_json:
        console.note("No background processes.")
        return 0
    # Processes of a launch that is stopped end with it, and the router is needed until the end.
    ending = {entry.record.pid for entry in chosen}
    chosen = [entry for entry in chosen if entry.launch is None or entry.launch.pid not in ending]
    stopped: list[str] = []
    failures: list[TeleopctlError] = []
    for name, failure in _stop_in_order(chosen):
        if failure is not None:
            failures.append(failure)
            console.error(failure)
            continue
        stopped.append(name)
        if not as_json:
            console.out(f"{name} has been stopped")
            console.flush()
    if as_json:
        died_before = [{"name": each.qualified_name, "ending": str(each.ending)} for each in gone]
        console.out_json({"stopped": stopped, "died": died_before})
    for entry in gone:
        forget_died(entry)
    return failures[0].exit_status if failures else 0


def _agreed(entries: Sequence[Running]) -> bool:
    """Prompt the user on the terminal whether to stop all processes; return the answer.

    Raises:
        UsageError: Stdin or stderr is not a terminal.
    """
    names = ", ".join(entry.record.name for entry in entries)
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise UsageError(
            f"Name what to stop: {names}",
            hint="`teleopctl stop --yes` stops all of these, `--all` the router as well.",
        )
    sys.stderr.write(f"Stop {printable_line(names)}? [y/N] ")
    sys.stderr.flush()
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _names_of(entry: Running) -> set[str]:
    """Return the names by which a user may refer to a process, including its launch's name."""
    names = {entry.record.name, entry.qualified_name, entry.node_name or entry.record.name}
    return names | ({entry.launch.name} if entry.launch else set())


def _found(name: str, told: set[str]) -> list[Running]:
    try:
        return find_running(name)
    except NotFoundError:
        if name in told:
            return []
        from teleopctl.cli.verbs.stop.nodes import process_of_node

        try:
            return [process_of_node(name)]
        except NotFoundError as unknown:
            if name.startswith("/"):
                raise unknown from None
        raise


def _stop_in_order(entries: Sequence[Running]) -> Iterator[tuple[str, TeleopctlError | None]]:
    """Stop all processes at the same time, and the router last.

    Yields:
        Name of each process, and the error if it does not end, or None.
    """
    from concurrent.futures import ThreadPoolExecutor

    routers = [entry for entry in entries if entry.record.kind == "router"]
    others = [entry for entry in entries if entry.record.kind != "router"]
    for together in (others, routers):
        with ThreadPoolExecutor(max_workers=max(1, len(together))) as threads:
            yield from threads.map(_stop, together)


def _stop(entry: Running) -> tuple[str, TeleopctlError | None]:
    if entry.launch is not None:
        mark_stopped(folder_of(entry.launch), entry.record.name)
    try:
        stop_running(entry.record)
    except TeleopctlError as failure:
        return entry.record.name, failure
    return entry.record.name, None
