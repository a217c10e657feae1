"""``python -m teleopctl.nodes [--builtin] [PACKAGE] EXECUTABLE [ARGS…]``: runs one executable.

``teleopctl run`` and ``launch`` start this module, so it imports nothing that the node does not
need. They pass ``-P``, so that a ``random.py`` in the current folder does not replace Python's. The
first argument is the path of a file or the name of a package; with ``--builtin``, only packages of
teleopctl itself are searched.
"""

import contextlib
import gc
import os
import sys

from teleopctl.base import interrupts, progress, standby
from teleopctl.base.printable import printable_text
from teleopctl.errors import EXIT_INTERRUPTED, TeleopctlError
from teleopctl.nodes.execute import preload, run_executable
from teleopctl.packages import is_path

_USAGE = "usage: python -m teleopctl.nodes [--builtin] [PACKAGE] EXECUTABLE [ARGS...]"


def main() -> int:
    """Run the executable named on the command line in this process; return its exit status."""
    status = 1
    # Imports make thousands of objects and no garbage: looking for some would be a tenth of them.
    gc.disable()
    try:
        # A shell starts its background jobs with SIGINT ignored, but the supervisor of this
        # process stops it with SIGINT.
        interrupts.install_sigint_handler()
        if standby.VARIABLE in os.environ and not _stand_by():
            return 0
        progress.report(progress.STARTED)
        status = _run()
    except KeyboardInterrupt:
        status = EXIT_INTERRUPTED
    except SystemExit as ending:
        status = ending.code if isinstance(ending.code, int) else int(ending.code is not None)
        raise
    finally:
        interrupts.clear_exec_interrupt()
        progress.report(progress.ENDED, str(status))
    return status


def _stand_by() -> bool:
    """Import the modules of the program, and wait for its arguments; return False without any."""
    # An error is raised again where the modules are needed.
    with contextlib.suppress(Exception):
        preload(*sys.argv[-2:])
    return standby.receive_order()


def _run() -> int:
    arguments = sys.argv[1:]
    builtin = arguments[:1] == ["--builtin"]
    if builtin:
        del arguments[0]
    if arguments and is_path(arguments[0]):
        package, executable, rest = None, arguments[0], arguments[1:]
    elif len(arguments) > 1:
        package, executable, rest = arguments[0], arguments[1], arguments[2:]
    else:
        sys.stderr.write(f"{_USAGE}\n")
        return 2
    try:
        return run_executable(package, executable, rest, builtin=builtin)
    except TeleopctlError as error:
        sys.stderr.write(f"{printable_text(error.message)}\n")
        if error.hint:
            sys.stderr.write(f"{printable_text(error.hint)}\n")
        return error.exit_status


if __name__ == "__main__":
    sys.exit(main())
