"""Has browsers that read slowly look at the page for long, and prints what its process holds.

``python -m tests.faults.page_soak [--minutes N]``: joints at 50 Hz, a camera at 30 Hz and ten
plots; four browsers: three that read 4, 20 and 60 kB/s, and one that reads for a minute and then
not for four. A browser that is let go comes again. At the end stands how fast memory grew in the
second half: after 11 minutes the plots' history has all the room that it gets.
"""

from __future__ import annotations

import argparse
import contextlib
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
import psutil
import viser
import yaml
from websockets.client import ClientProtocol
from websockets.typing import Subprotocol
from websockets.uri import parse_uri

from teleopctl.packages import package_share
from teleopctl.robot import Joints, RobotDescription, expand_xacro
from teleopctl.testing import LONGEST_WAIT_S, free_port
from tests.benchmarks.page_client import CAMERA, PageClient, show_everything
from tests.faults.isolation import own_graph

_ROOT = Path(__file__).parents[2]
_RATES = (4_000.0, 20_000.0, 60_000.0)
_READS_S, _SLEEPS_S = 60.0, 240.0
_SAMPLES = 120
_LINES = 12
_MB = 2**20


class SlowBrowser:
    """Client of the page that reads slowly on a thread, and reconnects, until the program ends.

    Args:
        port: TCP port of the page on this machine.
        rate: Bytes read per second; None reads without limit for 60 s, then not for 240 s.

    Attributes:
        let_go: Number of connections that have failed or that the page has closed.
    """

    def __init__(self, port: int, rate: float | None) -> None:
        self.let_go = 0
        self._port, self._rate = port, rate
        threading.Thread(target=self._look, daemon=True).start()

    def _look(self) -> None:
        while True:
            try:
                with socket.create_connection(("127.0.0.1", self._port)) as connection:
                    self._greet(connection)
                    self._read(connection)
            except OSError:
                self.let_go += 1
                time.sleep(1.0)

    def _greet(self, connection: socket.socket) -> None:
        protocol = ClientProtocol(
            parse_uri(f"ws://127.0.0.1:{self._port}/"),
            subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
            max_size=None,
        )
        protocol.send_request(protocol.connect())
        connection.sendall(b"".join(protocol.data_to_send()))
        while not protocol.events_received():
            protocol.receive_data(connection.recv(1024))
        protocol.send_binary(msgspec.msgpack.encode(CAMERA))
        connection.sendall(b"".join(protocol.data_to_send()))

    def _read(self, connection: socket.socket) -> None:
        begun_s = time.monotonic()
        size = _MB if self._rate is None else int(self._rate / 10)
        while self._rate is not None or time.monotonic() - begun_s < _READS_S:
            received = len(connection.recv(size))
            if not received:
                raise ConnectionAbortedError
            if self._rate is not None:
                time.sleep(received / self._rate)
        time.sleep(_SLEEPS_S)


@contextlib.contextmanager
def running(*words: str) -> Iterator[psutil.Process]:
    """Run a Python module during the ``with`` block; yield its process."""
    with subprocess.Popen([sys.executable, "-m", *words], cwd=_ROOT) as process:
        try:
            yield psutil.Process(process.pid)
        finally:
            process.kill()


@contextlib.contextmanager
def page_of_the_arm(port: int, folder: Path) -> Iterator[psutil.Process]:
    """Run the page and the publishers of the data it shows; yield the page's process."""
    urdf = expand_xacro(package_share("teleop_description") / "urdf" / "teleop.urdf.xacro", {})
    parameters = folder / "parameters.yaml"
    values = {"robot_description": urdf, "publish_frequency": 100.0}
    parameters.write_text(yaml.safe_dump({"/**": {"ros__parameters": values}}))
    names = list(Joints.of(RobotDescription.from_urdf(urdf)))
    publisher = "robot_state_publisher"
    with (
        running(
            *("teleopctl.nodes", publisher, publisher),
            *("--ros-args", "--params-file", str(parameters)),
        ),
        running("tests.benchmarks.page_peers", "feed", *names),
        running("teleopctl.nodes", "rviz2", "rviz2", "--port", str(port)) as page,
    ):
        yield page


def wait_for_page(port: int) -> None:
    """Wait until the page accepts connections; raise OSError after a timeout."""
    deadline_s = time.monotonic() + LONGEST_WAIT_S
    while True:
        try:
            socket.create_connection(("127.0.0.1", port)).close()
        except OSError:
            if time.monotonic() > deadline_s:
                raise
            time.sleep(0.1)
        else:
            return


def growth(samples: list[tuple[float, float]]) -> tuple[float, float]:
    """Return the memory growth in the samples' second half and its standard error, in MB/h."""
    hours, sizes = np.array(samples[len(samples) // 2 :]).T
    (slope, _), covariance = np.polyfit(hours, sizes, 1, cov=True)
    return float(slope), float(np.sqrt(covariance[0, 0]))


def main() -> None:
    """Run the page for the time given on the command line, and print its memory use."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0)
    seconds = 60.0 * parser.parse_args().minutes
    port = free_port()
    with (
        own_graph(),
        tempfile.TemporaryDirectory() as folder,
        page_of_the_arm(port, Path(folder)) as page,
    ):
        wait_for_page(port)
        with contextlib.closing(PageClient(port)) as client:
            show_everything(client)
            browsers = [SlowBrowser(port, rate) for rate in (*_RATES, None)]
            time.sleep(5.0)
        begun_s, samples = time.monotonic(), []
        for number in range(_SAMPLES + 1):
            time.sleep(max(0.0, begun_s + seconds * number / _SAMPLES - time.monotonic()))
            memory, hours = page.memory_full_info(), (time.monotonic() - begun_s) / 3600
            samples.append((hours, memory.uss / _MB))
            if number % (_SAMPLES // _LINES) == 0:
                print(
                    f"{60 * hours:5.1f} min: {memory.rss / _MB:.1f} MB, {memory.uss / _MB:.1f} MB "
                    f"of its own; {sum(one.let_go for one in browsers)} times a browser was let go",
                    flush=True,
                )
        print("second half: {:+.1f} ± {:.1f} MB an hour".format(*growth(samples)))


if __name__ == "__main__":
    main()
