"""Notices when files are saved, in whatever way the editor does it."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterable
from pathlib import Path

# One save is often several changes: a new file, a rename, a new time.
_TOGETHER_MS = 200
# How often the thread looks whether it is to end; it costs a thousandth of a core.
_STEP_MS = 100

_log = logging.getLogger(__name__)


class FileWatch:
    """Calls back when one of some files has changed.

    The folders are watched, not the files: many editors write a new file and rename it.

    Args:
        changed: Called in a thread of its own.
    """

    def __init__(self, changed: Callable[[], object]) -> None:
        self._changed = changed
        self._files: frozenset[str] = frozenset()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def watch(self, files: Iterable[Path]) -> None:
        """Watch these files and no others; they need not be there yet."""
        wanted = set()
        for file in files:
            # a link may be turned to another file, and its file may change
            wanted |= {str(file.absolute()), str(file.resolve())}
        if wanted == self._files:
            return
        self.close()
        self._files = frozenset(wanted)
        folders = sorted({str(Path(file).parent) for file in wanted})
        folders = [folder for folder in folders if Path(folder).is_dir()]
        if not folders:
            return
        self._stop = threading.Event()
        self._thread = threading.Thread(
            target=self._run, args=(folders, self._files, self._stop), name="watch", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Watch nothing any more."""
        self._stop.set()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(2.0)
        self._thread = None
        self._files = frozenset()

    def _run(self, folders: list[str], files: frozenset[str], stop: threading.Event) -> None:
        from watchfiles import watch

        logging.getLogger("watchfiles").setLevel(logging.WARNING)
        try:
            for _ in watch(
                *folders,
                watch_filter=lambda _change, path: path in files,
                debounce=_TOGETHER_MS,
                step=_STEP_MS,
                stop_event=stop,
                recursive=False,
                raise_interrupt=False,
                ignore_permission_denied=True,
            ):
                if stop.is_set():
                    return
                self._changed()
        except (OSError, RuntimeError) as error:
            # such as no more inotify watches: the page goes on without
            _log.warning("Saved files are not noticed: %s", error)
