"""The page in the browser beside viser's own shortest script, which draws the same arm.

The time until the robot is visible is that of a real browser; without a graphics card, software
draws, which is most of it. What a process takes of a core is measured with a client that reads as
fast as it is sent to, for both at the same time.
"""

import contextlib
import io
import re
import statistics
import time
from pathlib import Path
from urllib.parse import urlsplit

import psutil
import pytest
import yaml
from PIL import Image
from playwright.sync_api import Browser

from teleopctl.packages import package_share
from teleopctl.robot import Joints, RobotDescription, expand_xacro
from teleopctl.testing import RosGraph
from tests.benchmarks.figure import Figure
from tests.benchmarks.page_client import PageClient, show_everything
from tests.system.browser import browser

ROUNDS = 3
WINDOW_S = 20.0
ROOT = Path(__file__).parents[2]
ADDRESS = r"http://localhost:\d+/"
# Of a picture of 160 by 120 pixels: the arm is orange, and nothing else is.
ORANGE_PIXELS = 40


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    """The arm's description, without xacro."""
    file = tmp_path / "arm.urdf"
    model = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
    file.write_text(expand_xacro(model, {}))
    return file


def spawn(ros: RosGraph, *words: str) -> tuple[psutil.Process, str]:
    """Start one of `page_peers`; the process and the page's address."""
    process = ros.spawn_module("tests.benchmarks.page_peers", words, cwd=ROOT)
    return psutil.Process(process.pid), process.wait_for_line(ADDRESS)[0]


def launch(ros: RosGraph) -> str:
    done = ros.run("launch --detach display.yaml viewer:=true", 60)
    found = re.search(ADDRESS, done.stdout)
    assert found is not None, done.stderr
    return found[0]


def seconds_until_drawn(chromium: Browser, begun: float, address: str) -> list[float]:
    """Open a page; seconds from the command to its address, to a loaded page, to the robot."""
    times = [time.monotonic() - begun]
    page = chromium.new_page(viewport={"width": 640, "height": 480})
    page.goto(address, timeout=60_000)
    times.append(time.monotonic() - begun)
    while True:
        picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB").resize((160, 120))
        orange = sum(
            red > 150 and 60 < green < 170 and blue < 90
            for red, green, blue in zip(*[iter(picture.tobytes())] * 3, strict=True)
        )
        if orange > ORANGE_PIXELS:
            break
    times.append(time.monotonic() - begun)
    page.close()
    return times


@pytest.mark.timeout(300)
def test_from_the_command_to_the_robot_in_the_browser(
    ros: RosGraph, urdf: Path, figures: list[Figure]
):
    # The bytecode is cached, as after any installation.
    ros.env.update(PYTHONPYCACHEPREFIX=str(ros.folder / "bytecode"), PYTHONDONTWRITEBYTECODE="")
    runs: dict[str, list[list[float]]] = {"launch display.yaml": [], "viser's script": []}
    with browser() as chromium:
        for _ in range(ROUNDS + 1):
            begun = time.monotonic()
            ours = seconds_until_drawn(chromium, begun, launch(ros))
            runs["launch display.yaml"].append(ours)
            assert ros.run("stop display").returncode == 0
            begun = time.monotonic()
            process, address = spawn(ros, "minimal", str(urdf))
            runs["viser's script"].append(seconds_until_drawn(chromium, begun, address))
            process.kill()
    for name, times in runs.items():
        # The first round writes the bytecode.
        address_s, loaded_s, drawn_s = map(statistics.median, zip(*times[1:], strict=True))
        result = (
            f"{address_s:.2f} s to the address, {loaded_s:.2f} s to the loaded page, "
            f"{drawn_s:.2f} s to the robot"
        )
        figures.append(Figure(name, result))


@pytest.mark.timeout(180)
def test_joints_a_camera_and_ten_plots(ros: RosGraph, urdf: Path, figures: list[Figure]):
    names = list(Joints.of(RobotDescription.from_urdf(urdf.read_text())))
    parameters = ros.folder / "parameters.yaml"
    values = {"robot_description": urdf.read_text(), "publish_frequency": 100.0}
    parameters.write_text(yaml.safe_dump({"/**": {"ros__parameters": values}}))
    ros.spawn_module(
        "teleopctl.nodes",
        f"robot_state_publisher robot_state_publisher --ros-args --params-file {parameters}",
    )
    ros.spawn_module("tests.benchmarks.page_peers", ["feed", *names], cwd=ROOT)
    page = ros.spawn("run rviz2 rviz2 --port 0")
    address = page.wait_for_line(ADDRESS)[0]
    pages = {"page": (psutil.Process(page.pid), address), "viser": spawn(ros, "moving", str(urdf))}
    with contextlib.ExitStack() as stack:
        clients = {
            kind: stack.enter_context(contextlib.closing(PageClient(urlsplit(address).port or 0)))
            for kind, (_, address) in pages.items()
        }
        show_everything(clients["page"])
        before = {
            kind: (process.cpu_times(), clients[kind].counts.copy())
            for kind, (process, _) in pages.items()
        }
        time.sleep(WINDOW_S)
        for kind, (process, _) in pages.items():
            used, sent = process.cpu_times(), clients[kind].counts - before[kind][1]
            share = (used.user + used.system - sum(before[kind][0][:2])) / WINDOW_S
            figures.append(
                Figure(
                    f"joints, a camera and ten plots: {kind}",
                    f"{share:.1%} of a core, {process.memory_info().rss / 1e6:.0f} MB; "
                    f"{sent['SetPositionMessage'] + sent['SetOrientationMessage']} poses and "
                    f"{sent['data']} pictures and plots in {WINDOW_S:.0f} s",
                )
            )
