import signal
import subprocess
import sys

import pytest

from teleopctl.node.values import signals
from teleopctl.node.values.signals import SignalHandlerOptions

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


class Ended:
    """Context that a signal has ended, or not."""

    is_ended = False

    def ok(self) -> bool:
        return not self.is_ended

    def end_by_signal(self) -> None:
        self.is_ended = True


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT cannot be raised alone there")
def test_a_program_may_install_the_handlers_itself_and_take_them_away(monkeypatch):
    monkeypatch.setattr(signals, "_initialized", set())
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        context = Ended()
        signals.install_signal_handlers(context, SignalHandlerOptions.NO)
        signals.install_for_all_contexts(SignalHandlerOptions.SIGTERM)
        signals.uninstall_for_all_contexts()
        signal.raise_signal(signal.SIGTERM)
        assert not context.is_ended
        signals.install_for_all_contexts(SignalHandlerOptions.SIGTERM)
        signal.raise_signal(signal.SIGTERM)
        assert context.is_ended
        signals.uninstall_for_all_contexts()
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGTERM, before)
