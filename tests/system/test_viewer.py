"""The page as a user has it: started by a launch file, opened in a real browser."""

import re
import urllib.request
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from teleopctl.testing import RosGraph
from tests.system.browser import browser

ADDRESS = re.compile(r"^The robot in your browser: (http://localhost:\d+/)$", re.MULTILINE)
PAGE_WITHIN_MS = 60_000


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


def test_launch_ends_with_the_address_of_a_page_that_is_there(ros):
    address = launched(ros, "display.yaml")
    assert urllib.request.urlopen(address, timeout=10).status == 200
    assert "/rviz" in ros.run("node list").stdout.split()
    assert "rviz" in ros.run("ps").stdout


def test_without_a_viewer_there_is_no_page(ros):
    done = ros.run(["launch", "--detach", "display.yaml", "viewer:=false"], 60)
    assert ADDRESS.search(done.stdout) is None
    assert "/rviz" not in ros.run("node list").stdout.split()
