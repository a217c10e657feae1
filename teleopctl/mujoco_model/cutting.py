"""Hollow meshes are cut ahead of the model that needs them: announced, side by side, interruptible.

A cut is one call of CoACD, of a second for a simple part and half a minute for one of 20,000
triangles, which listens to nothing meanwhile. So processes of their own do the cutting, one for
each core, and leave the pieces where `convex_pieces` finds them, in the user's cache folder.
``python -m teleopctl.mujoco_model.cutting FILE …`` is one of them.
"""

from __future__ import annotations

import logging
import os
import subprocess
import sys
from collections.abc import Collection
from pathlib import Path

from teleopctl.base import progress
from teleopctl.mujoco_model.convex import convex_pieces, is_to_cut

_log = logging.getLogger(__name__)

_CUTTING = "cutting hollow meshes into convex pieces"
# Each process writes this line after each of its meshes.
_DONE = b"done\n"


def cut_ahead(files: Collection[Path]) -> None:
    """Decompose hollow mesh files in parallel, and cache the pieces.

    What cannot be cut so, because no process can be started or the folder cannot be written, is
    left to `convex_pieces`.
    """
    missing = sorted({file for file in files if is_to_cut(file)}, key=_size, reverse=True)
    if not missing:
        return
    _log.warning(
        "Cutting hollow meshes into convex pieces, up to half a minute for each: %s. They are kept "
        "for the next time",
        ", ".join(file.name for file in missing),
    )
    count = min(len(missing), os.cpu_count() or 1)
    progress.doing(_CUTTING)
    processes: list[subprocess.Popen[bytes]] = []
    read, write = os.pipe()
    try:
        for number in range(count):
            # The largest first, and the others dealt out: none waits long for the last.
            share = [str(file.absolute()) for file in missing[number::count]]
            command = [sys.executable, "-P", "-m", __name__, *share]
            # Ctrl-C comes to them too, and each would say so.
            nowhere = subprocess.DEVNULL
            processes.append(subprocess.Popen(command, stdin=nowhere, stdout=write, stderr=nowhere))
        os.close(write)
        write = -1
        with open(read, "rb", closefd=False) as lines:
            for done, _ in enumerate((line for line in lines if line == _DONE), 1):
                progress.doing(f"{_CUTTING}: {done} of {len(missing)}")
        for process in processes:
            process.wait()
    except OSError:
        pass  # convex_pieces will do it
    finally:
        os.close(read)
        if write != -1:
            os.close(write)
        for process in processes:
            process.kill()
            process.wait()


def _size(file: Path) -> int:
    return file.stat().st_size


if __name__ == "__main__":
    for argument in sys.argv[1:]:
        convex_pieces(Path(argument))
        os.write(1, _DONE)
