"""``teleopctl control reload``: a controller's changed code takes over while the robot moves."""

from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.control.manager import ControllerName, ManagerOptions
from teleopctl.errors import RefusedError, UsageError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from teleopctl.control import ControllerManagerClient


def reload(
    controller_name: ControllerName,
    watch: Annotated[
        bool, Option("--watch", help="Reload whenever a file of its code is saved.")
    ] = False,
    timeout: Annotated[
        float,
        Option("--timeout", help="Longest time until the new code is configured, s.", metavar="S"),
    ] = 10.0,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """Run a controller's changed code without stopping it.

    The new code is imported and configured beside the running one, and takes over between two
    control cycles, with state, claims, parameters and goals. If it fails, also in its first update,
    the old code still runs.
    """
    if timeout <= 0.0:
        raise UsageError(f"--timeout must be above 0, got {timeout:g}")
    with manager.client() as client:
        try:
            files = _reload(client, controller_name, timeout, as_json)
        except _NotReloadedError as failure:
            if not watch:
                raise
            files = failure.files
            console.error(failure)
        if watch:
            _watch(client, controller_name, timeout, files, as_json)


class _NotReloadedError(RefusedError):
    """Raised when a controller is not reloaded and its old code still runs.

    Attributes:
        files: Paths of its files.
    """

    def __init__(self, message: str, files: "list[str]") -> None:
        super().__init__(message)
        self.files = files


def _reload(
    client: "ControllerManagerClient", name: str, timeout: float, as_json: bool
) -> "list[str]":
    """Reload a controller and print what was reloaded; return the paths of its files."""
    ok, message, files = client.reload_controller(name, timeout)
    if not ok:
        raise _NotReloadedError(message, files)
    console.out_done(
        message, as_json=as_json, controller=name, reloaded=True, message=message, files=files
    )
    console.flush()
    return files


def _watch(
    client: "ControllerManagerClient",
    name: str,
    timeout: float,
    files: "Iterable[str]",
    as_json: bool,
) -> None:
    """Reload a controller whenever one of its files is saved, until Ctrl-C."""
    import queue

    from teleopctl.base.file_watch import FileWatch

    saved: queue.SimpleQueue[frozenset[Path]] = queue.SimpleQueue()
    watch = FileWatch(saved.put, console.warn)
    watched: list[Path] = []
    try:
        while True:
            paths = sorted(Path(file) for file in files)
            if not any(path.is_file() for path in paths):
                raise RefusedError(
                    f"No file of controller '{name}' is on this machine",
                    hint="Its code is that of the controller manager's process: watch it there.",
                )
            if paths != watched:
                watched = paths
                watch.watch(paths)
                console.note(f"Watching {', '.join(map(str, paths))}; Ctrl-C ends")
            saved.get()
            while not saved.empty():
                saved.get()
            try:
                files = _reload(client, name, timeout, as_json)
            except _NotReloadedError as failure:
                console.error(failure)
                files = failure.files or files
    finally:
        watch.close()
