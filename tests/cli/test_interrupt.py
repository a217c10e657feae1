"""Ctrl-C ends the command line at any moment, without a traceback."""

from __future__ import annotations

import signal
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pathlib import Path

# Sends the signal when a module is looked for, as a hurried person does by chance.
_COMMAND = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)

class Interrupt:
    def find_spec(self, name, path, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupt())
sys.argv[1:] = ["topic", "list"]
from teleopctl.__main__ import main
main()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="os.kill ends a process there")
@pytest.mark.parametrize(
    ("module", "status"),
    [
        ("teleopctl.base.interrupts", -signal.SIGINT),
        ("teleopctl.cli.main", -signal.SIGINT),
        ("teleopctl.cli.console", -signal.SIGINT),
        ("teleopctl.plugins", 130),
        ("teleopctl.cli.quick", 130),
        ("zenoh", 130),
    ],
)
def test_an_interrupt_while_a_module_is_imported_ends_it_in_silence(module: str, status: int):
    done = subprocess.run(
        [sys.executable, "-c", _COMMAND.format(module=module)],
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (status, "", "")


_IN_A_CALL_FROM_ZENOH = """
import signal, threading
from teleopctl.base import interrupts

@interrupts.transport_callback
def called():
    signal.raise_signal(signal.SIGINT)
    print("the whole call")

interrupts.install_sigint_handler()
try:
    called()
    threading.Event().wait(10)
except KeyboardInterrupt:
    print("interrupted behind it")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT cannot be raised alone there")
def test_an_interrupt_in_a_call_from_zenoh_comes_again_behind_it() -> None:
    done = subprocess.run(
        [sys.executable, "-c", _IN_A_CALL_FROM_ZENOH],
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert (done.stdout, done.stderr) == ("the whole call\ninterrupted behind it\n", "")


# Sends the signal where Python wraps what is raised into a RuntimeError, before its version 3.12.
_WRAPPED = _COMMAND.replace(
    "            os.kill(os.getpid(), signal.SIGINT)\n",
    """            class Named:
                def __set_name__(self, owner, name):
                    os.kill(os.getpid(), signal.SIGINT)
                    for _ in range(1000):
                        pass
            class Owner:
                named = Named()
""",
)


@pytest.mark.skipif(sys.platform == "win32", reason="os.kill ends a process there")
def test_an_interrupt_that_python_wraps_into_an_error_ends_it_in_silence() -> None:
    done = subprocess.run(
        [sys.executable, "-c", _WRAPPED.format(module="teleopctl.cli.quick")],
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


# Sends the signal where Python swallows what is raised, as callbacks of its imports do.
_SWALLOWED = _COMMAND.replace(
    "            os.kill(os.getpid(), signal.SIGINT)\n",
    """            class Gone:
                def __del__(self):
                    os.kill(os.getpid(), signal.SIGINT)
                    for _ in range(1000):
                        pass
            Gone()
""",
)
# A user's node without a handler of its own, which has to be waiting when the signal comes again.
_NODE = "import colorsys, threading\nthreading.Event().wait(20)\n"
_OF_A_NODE = (
    _SWALLOWED.replace('["topic", "list"]', "[{node!r}]")
    .replace("teleopctl.__main__", "teleopctl.nodes.__main__")
    .replace("\nmain()", "\nsys.exit(main())")
)


@pytest.mark.skipif(sys.platform == "win32", reason="os.kill ends a process there")
@pytest.mark.parametrize(
    ("program", "module"),
    [(_SWALLOWED, "teleopctl.cli.quick"), (_OF_A_NODE, "colorsys")],
    ids=["command", "node"],
)
def test_an_interrupt_that_python_swallows_comes_again(
    program: str, module: str, tmp_path: Path
) -> None:
    node = tmp_path / "node.py"
    node.write_text(_NODE)
    done = subprocess.run(
        [sys.executable, "-c", program.format(module=module, node=str(node))],
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")
