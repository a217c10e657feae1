"""The page as a user has it: started by a launch file, opened in a real browser."""

import re
import urllib.request
from collections.abc import Iterator

import pytest
import yaml
from playwright.sync_api import Browser, Page, expect

from teleopctl.testing import RosGraph, eventually
from tests.system.browser import browser

ADDRESS = re.compile(r"^The robot in your browser: (http://localhost:\d+/)$", re.MULTILINE)
PAGE_WITHIN_MS = 60_000


VIEW = """
Visualization Manager:
  Displays:
    - {Class: rviz_default_plugins/RobotModel, Name: Robot, Enabled: true,
       Description Topic: {Value: /robot_description}}
    - {Class: rviz_default_plugins/TF, Name: Frames of mine, Enabled: true, Marker Scale: 0.25}
    - {Class: somebody_rviz/Odd, Name: Odd, Number: 3}
  Global Options: {Fixed Frame: base_plate, Background Color: 30; 60; 90}
  Views:
    Current:
      {Class: rviz_default_plugins/Orbit, Distance: 1.5, Pitch: 0.4, Yaw: 0.8,
       Focal Point: {X: 0, Y: 0, Z: 0.3}}
"""


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as started:
        yield started


def launched(ros: RosGraph, *words: str) -> str:
    """Launch in the background with the page, and return its address, the last line."""
    done = ros.run(["launch", "--detach", *words, "viewer:=true"], 60)
    assert done.returncode == 0, done.stderr
    last = ADDRESS.fullmatch(done.stdout.splitlines()[-1])
    assert last is not None, done.stdout
    return last[1]


def run_page(ros: RosGraph, *words: str) -> str:
    """Run the page alone in the background, and return its address."""
    done = ros.run(["run", "--detach", "rviz2", "rviz2", *words], 60)
    assert done.returncode == 0, done.stderr
    found = ADDRESS.search(done.stdout)
    assert found is not None, done.stdout
    return found[1]


def page_log(ros: RosGraph) -> str:
    return ros.run("logs rviz2").stdout


def opened(chromium: Browser, address: str) -> Page:
    page = chromium.new_page(viewport={"width": 1280, "height": 800})
    page.set_default_timeout(PAGE_WITHIN_MS)
    page.goto(address)
    return page


def test_the_page_shows_the_joints_of_the_robot(ros, chromium):
    page = opened(chromium, launched(ros, "display.yaml"))
    for joint in ("joint_1", "joint_2", "joint_3", "joint_4"):
        expect(page.get_by_text(joint, exact=True)).to_be_visible(timeout=PAGE_WITHIN_MS)
    # joint_5 follows joint_4
    expect(page.get_by_text("joint_5", exact=True)).to_have_count(0)


def test_nothing_is_listened_to_while_nobody_looks(ros, chromium):
    address = launched(ros, "display.yaml")

    def listens() -> bool:
        topics = ros.run("node info /rviz").stdout.partition("Publishers:")[0]
        return "/joint_states" in topics or "/tf:" in topics

    assert not listens()
    page = opened(chromium, address)
    eventually(listens)
    page.close()
    eventually(lambda: not listens())


def test_a_view_of_rviz_is_shown_and_saved_where_it_was(ros, chromium):
    view = ros.folder / "mine.rviz"
    view.write_text(VIEW)
    ros.launch("display.yaml")
    page = opened(chromium, run_page(ros, "-d", str(view)))
    page.get_by_role("tab", name="Scene").click()
    page.get_by_text("Frames of mine").click()
    expect(page.get_by_text("Marker Scale")).to_be_visible()
    page.get_by_role("button", name="Save view").click()
    eventually(lambda: yaml.safe_load(view.read_text()) != yaml.safe_load(VIEW))
    saved = yaml.safe_load(view.read_text())["Visualization Manager"]
    before = yaml.safe_load(VIEW)["Visualization Manager"]
    assert saved["Displays"] == before["Displays"]
    assert saved["Global Options"]["Fixed Frame"] == "base_plate"
    assert saved["Views"]["Current"]["Distance"] == pytest.approx(1.5, abs=0.01)
    assert "Odd" in page_log(ros)


def test_launch_ends_with_the_address_of_a_page_that_is_there(ros):
    address = launched(ros, "display.yaml")
    assert urllib.request.urlopen(address, timeout=10).status == 200
    assert "/rviz" in ros.run("node list").stdout.split()
    assert "rviz" in ros.run("ps").stdout


def test_without_a_viewer_there_is_no_page(ros):
    done = ros.run(["launch", "--detach", "display.yaml", "viewer:=false"], 60)
    assert ADDRESS.search(done.stdout) is None
    assert "/rviz" not in ros.run("node list").stdout.split()
