"""Detection of saved files, in whatever way an editor writes them."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterable
from pathlib import Path

# One save is often several changes: a new file, a rename, a new time.
_TOGETHER_MS = 200
# Period at which the thread checks whether to end; costs a thousandth of a core.
_STEP_MS = 100
# By then the system reports changes; files saved earlier are found by one comparison of stamps.
_BEGUN_AFTER_MS = 1000

_log = logging.getLogger(__name__)


class FileWatch:
    """Watcher of files that calls a function on a thread of its own after some have changed.

    The folders are watched, not the files: many editors write a new file and rename it.

    Args:
        changed: Called with the changed files, in the watching thread.
        on_trouble: Called with a sentence when files cannot be watched; logs a warning by default.
    """

    def __init__(
        self,
        changed: Callable[[frozenset[Path]], object],
        on_trouble: Callable[[str], object] = _log.warning,
    ) -> None:
        self._changed = changed
        self._on_trouble = on_trouble
        # Keys: paths under which changes are reported. Values: the files as given.
        self._files: dict[str, Path] = {}
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def watch(self, files: Iterable[Path]) -> None:
        """Watch these files instead of earlier ones; a file may be missing, but not its folder."""
        wanted: dict[str, Path] = {}
        for file in files:
            # For a symbolic link, both the link and its target may change.
            wanted[str(file.resolve())] = wanted[str(file.absolute())] = file
        if wanted == self._files:
            return
        self._stop.set()
        self._files = wanted
        folders = sorted({str(Path(file).parent) for file in wanted})
        folders = [folder for folder in folders if Path(folder).is_dir()]
        if not folders:
            return
        self._stop = threading.Event()
        self._thread = threading.Thread(
            target=self._run,
            args=(folders, wanted, _stamps(wanted), self._stop),
            name="watch",
            daemon=True,
        )
        self._thread.start()

    def close(self) -> None:
        """Stop watching the files, and wait up to 2 s for the thread to end."""
        self._stop.set()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(2.0)
        self._thread = None
        self._files = {}

    def _run(
        self,
        folders: list[str],
        files: dict[str, Path],
        stamps: dict[str, object],
        stop: threading.Event,
    ) -> None:
        from watchfiles import watch

        logging.getLogger("watchfiles").setLevel(logging.WARNING)
        try:
            for changes in watch(
                *folders,
                watch_filter=lambda _change, path: path in files,
                debounce=_TOGETHER_MS,
                step=_STEP_MS,
                stop_event=stop,
                rust_timeout=_BEGUN_AFTER_MS,
                yield_on_timeout=True,
                recursive=False,
                raise_interrupt=False,
                ignore_permission_denied=True,
            ):
                if stop.is_set():
                    return
                changed = {path for _, path in changes}
                if stamps and changed:
                    stamps |= _stamps(changed)
                elif stamps:
                    now = _stamps(files)
                    changed = {path for path in files if stamps[path] != now[path]}
                    stamps = {}
                if changed:
                    self._changed(frozenset(files[path] for path in changed))
        except (OSError, RuntimeError) as error:
            # Such as no more inotify watches; the program continues without the watch.
            self._on_trouble(f"Saved files are not noticed: {error}")


def _stamps(files: Iterable[str]) -> dict[str, object]:
    """Modification time, size and inode of each file; None for a missing file."""
    stamps: dict[str, object] = {}
    for path in files:
        try:
            found = Path(path).stat()
        except OSError:
            stamps[path] = None
        else:
            stamps[path] = (found.st_mtime_ns, found.st_size, found.st_ino)
    return stamps
