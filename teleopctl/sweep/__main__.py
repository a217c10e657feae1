"""``python -m teleopctl.sweep FOLDER``: one run of a sweep, as the sweep starts it.

With ``--guarded`` the run is stopped at the end of standard input, which is a pipe: it ends when
the parent process ends.
"""

from __future__ import annotations

import signal
import sys
import threading
from pathlib import Path

from teleopctl.base import interrupts
from teleopctl.compat import activation
from teleopctl.errors import EXIT_INTERRUPTED
from teleopctl.sweep.one_run import run_once
from teleopctl.sweep.process import GUARDED


def _stop_with_input() -> None:
    sys.stdin.buffer.read()
    signal.raise_signal(signal.SIGINT)


if __name__ == "__main__":
    interrupts.install_sigint_handler()
    activation.activate_children()
    signal.signal(signal.SIGTERM, signal.getsignal(signal.SIGINT))
    if GUARDED in sys.argv[2:]:
        threading.Thread(target=_stop_with_input, daemon=True).start()
    try:
        sys.exit(0 if run_once(Path(sys.argv[1])).is_done else 1)
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)
