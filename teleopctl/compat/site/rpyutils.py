"""``rpyutils``: preparation for imports of packages with C libraries."""

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager


@contextmanager
def add_dll_directories_from_env(env_name: str) -> Iterator[None]:
    """Add the folders that an environment variable names to Windows' search path of DLLs.

    The folders count while the ``with`` block runs. Elsewhere the system's loader needs no help.
    """
    add = getattr(os, "add_dll_directory", None)
    with ExitStack() as added:
        for folder in os.environ.get(env_name, "").split(os.pathsep):
            if add is not None and os.path.isdir(folder):  # noqa: PTH112 -- text of a variable
                added.enter_context(add(folder))
        yield
