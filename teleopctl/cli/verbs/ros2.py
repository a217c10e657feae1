"""``teleopctl ros2``: ``ros2`` and other commands of ROS 2 by their own names, in this environment.

Each is a small script in the folder of the environment's programs that starts teleopctl. A program
of ROS 2 itself is never replaced, nor put behind one of these.
"""

import os
import shutil
import sys
import sysconfig
from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option, Verb, VerbGroup
from teleopctl.errors import RefusedError, SystemFailureError

if TYPE_CHECKING:
    from collections.abc import Iterator

GROUP = VerbGroup(
    "Make the word ros2 work in this environment.",
    {
        "install": Verb(
            f"{__name__}:install",
            "Put ros2, rqt, rviz2 and the like into this environment's folder of programs.",
            examples=('teleopctl ros2 install && eval "$(teleopctl completion bash --as ros2)"',),
        ),
        "remove": Verb(f"{__name__}:remove", "Remove them again."),
    },
)

_COMMANDS = {
    "ros2": (),
    **{
        name: ("run", name, name)
        for name in ("rqt", "rqt_console", "rqt_graph", "rqt_plot", "rviz2")
    },
}
"""Words of teleopctl's command line for each command of ROS 2."""

# In each script; a file without it is not ours.
_MARK = "made by `teleopctl ros2 install`"


def install(
    only_ros2: Annotated[
        bool, Option("--only-ros2", help="Leave rqt, rqt_graph, rviz2 and the like out.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Put scripts named ros2, rqt, rqt_graph, rqt_console, rqt_plot and rviz2 on the PATH.

    They start this teleopctl. A program of the same name from elsewhere, such as a real ros2, is
    left as it is, and named on stderr.
    """
    folder = _folder()
    made, kept = [], []
    for name in ("ros2",) if only_ros2 else _COMMANDS:
        real = _real_program(name, folder)
        if real is None:
            made.append(_write(folder, name))
        elif name == "ros2":
            raise RefusedError(
                f"ros2 is here already: {real}",
                hint="It stays as it is. Use teleopctl by its own name beside it.",
            )
        else:
            kept.append(str(real))
    if as_json:
        console.out_json({"made": [str(file) for file in made], "kept": kept})
        return
    console.out_lines(map(str, made))
    for program in kept:
        console.note(f"{program} stays as it is.")
    if str(folder) not in os.environ.get("PATH", "").split(os.pathsep):
        console.warn(f"{folder} is not on the PATH: activate the environment")


def remove(as_json: AsJson = False) -> None:
    """Remove the scripts that `teleopctl ros2 install` has made; other programs are left alone."""
    removed = []
    for name in _COMMANDS:
        for file in _files(_folder(), name):
            if _is_ours(file):
                try:
                    file.unlink()
                except OSError as error:
                    raise SystemFailureError(f"Cannot remove {file}: {error.strerror}") from error
                removed.append(str(file))
    if as_json:
        console.out_json({"removed": removed})
    elif removed:
        console.out_lines(f"{file} has been removed" for file in removed)
    else:
        console.note("Nothing of `teleopctl ros2 install` is here.")


def _folder() -> Path:
    """Return the folder of this environment's programs, as of `teleopctl` itself."""
    return Path(sysconfig.get_path("scripts"))


def _files(folder: Path, name: str) -> "Iterator[Path]":
    """Yield the file of a script, where there is one."""
    file = folder / (f"{name}.cmd" if os.name == "nt" else name)
    if file.exists() or file.is_symlink():
        yield file


def _is_ours(file: Path) -> bool:
    try:
        return _MARK in file.read_text(encoding="utf-8", errors="replace")[:500]
    except OSError:
        return False


def _real_program(name: str, folder: Path) -> Path | None:
    """Return a program of this name that is not a script of ours; None if there is none."""
    from teleopctl.compat import activation

    for file in _files(folder, name):
        if not _is_ours(file):
            return file
    # Programs that teleopctl starts have its stand-ins at the end of their PATH.
    places = [
        place
        for place in os.environ.get("PATH", os.defpath).split(os.pathsep)
        if place not in (str(folder), activation.PROGRAMS)
    ]
    found = shutil.which(name, path=os.pathsep.join(places))
    return None if found is None or _is_ours(Path(found)) else Path(found)


def _write(folder: Path, name: str) -> Path:
    """Write the script of a command, and return its file."""
    words = _COMMANDS[name]
    file = folder / (f"{name}.cmd" if os.name == "nt" else name)
    if os.name == "nt":
        start = f"import sys; sys.argv[0] = '{name}'; from teleopctl.__main__ import main; main()"
        rest = " ".join(words)
        text = f'@rem {_MARK}\r\n@"{sys.executable}" -P -c "{start}" {rest} %*\r\n'
    else:
        # Not as the first line: that may be too long, or have blanks.
        text = (
            "#!/bin/sh\n"
            f'\'\'\'exec\' "{sys.executable}" -P "$0" "$@"\n'
            f"' '''\n# {_MARK}\n"
            "import sys\n\n"
            "from teleopctl.__main__ import main\n\n"
            f"sys.argv[1:1] = {[*words]!r}\n"
            "main()\n"
        )
    try:
        file.write_text(text, encoding="utf-8")
        if os.name != "nt":
            file.chmod(0o755)
    except OSError as error:
        raise SystemFailureError(f"Cannot write {file}: {error.strerror}") from error
    return file
