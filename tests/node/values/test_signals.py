import subprocess
import sys

import pytest

PROGRAM = """
import signal, threading
from teleopctl.node import Context, SignalHandlerOptions
from teleopctl.node.values import signals
from teleopctl.base.interrupts import transport_callback

class Running:
    ended = False
    def ok(self):
        return not self.ended
    def end_by_signal(self):
        self.ended = True

# A script starts what it puts into the background, this test say, with SIGINT ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
running = Running()
signals.install_signal_handlers(running, SignalHandlerOptions.SIGINT)

@transport_callback
def called_by_zenoh():
    signal.raise_signal(signal.SIGINT)
    return running.ok()

try:
    assert called_by_zenoh(), "the context ended in the middle of the call"
    threading.Event().wait(10)
except KeyboardInterrupt:
    print("interrupted behind the call", running.ok())
"""


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT cannot be raised alone there")
def test_an_interrupt_in_a_call_from_zenoh_comes_again_behind_it(ros):
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env=ros.env,
        capture_output=True,
        text=True,
        check=False,
        timeout=30,
    )
    assert (done.stdout, done.stderr) == ("interrupted behind the call False\n", "")
