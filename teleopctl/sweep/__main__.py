"""``python -m teleopctl.sweep FOLDER``: one run of a sweep, as the sweep starts it."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

from teleopctl import interrupts
from teleopctl.errors import EXIT_INTERRUPTED
from teleopctl.sweep.one_run import run_once

if __name__ == "__main__":
    interrupts.take()
    signal.signal(signal.SIGTERM, signal.getsignal(signal.SIGINT))
    try:
        sys.exit(0 if run_once(Path(sys.argv[1])).is_done else 1)
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)
