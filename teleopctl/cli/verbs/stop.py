"""``teleopctl stop``: ends what runs in the background."""

from collections.abc import Sequence
from typing import Annotated

from teleopctl.cli import console
from teleopctl.cli.verb import Argument, Option, Verb
from teleopctl.launch import Running, find_running, folder_of, mark_stopped, running, stop_running

VERB = Verb(
    f"{__name__}:stop",
    "End background processes: SIGINT, after 5 s SIGTERM, after 5 s more SIGKILL.",
)


def stop(
    names: Annotated[
        list[str] | None,
        Argument(
            metavar="NAME",
            help="As `teleopctl ps` lists them, or nodes; none for every node and launch.",
            complete="running_processes",
        ),
    ] = None,
    everything: Annotated[
        bool, Option("--all", help="Stop every node and launch, and then the router.")
    ] = False,
) -> int:
    """End background processes: SIGINT, after 5 s SIGTERM, after 5 s more SIGKILL."""
    if names:
        chosen = list(dict.fromkeys(entry for name in names for entry in find_running(name)))
    else:
        chosen = [entry for entry in running() if entry.launch is None]
        if not everything:
            chosen = [entry for entry in chosen if entry.record.kind != "router"]
    if not chosen:
        console.note("Nothing runs in the background.")
        return 0
    # What is in a launch that ends anyway ends with it, and the router is needed until the last.
    ending = {entry.record.pid for entry in chosen}
    chosen = [entry for entry in chosen if entry.launch is None or entry.launch.pid not in ending]
    _stop_together([entry for entry in chosen if entry.record.kind != "router"])
    _stop_together([entry for entry in chosen if entry.record.kind == "router"])
    return 0


def _stop_together(entries: Sequence[Running]) -> None:
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(max_workers=max(1, len(entries))) as threads:
        for name in threads.map(_stop, entries):
            console.out(f"{name} has been stopped")
            console.flush()


def _stop(entry: Running) -> str:
    if entry.launch is not None:
        mark_stopped(folder_of(entry.launch), entry.record.name)
    stop_running(entry.record)
    return entry.record.name
