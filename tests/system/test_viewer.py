"""The page as a user has it: started by a launch file, opened in a real browser."""

import re
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import pytest
import yaml
from playwright.sync_api import Browser, Locator, Page, expect

from teleopctl.interfaces import get_action, get_message, get_service
from teleopctl.node import ActionServer, Publisher
from teleopctl.packages import package_share
from teleopctl.robot import Joints, RobotDescription, SegmentTree, expand_xacro
from teleopctl.testing import RosGraph, eventually
from tests.system.browser import browser, open_page
from tests.system.window import window

JointState = get_message("sensor_msgs/msg/JointState")
Image = get_message("sensor_msgs/msg/Image")
String = get_message("std_msgs/msg/String")
SetBool = get_service("std_srvs/srv/SetBool")
Fibonacci = get_action("example_interfaces/action/Fibonacci")
TFMessage = get_message("tf2_msgs/msg/TFMessage")

ADDRESS = re.compile(r"^The robot in your browser: (http://localhost:\d+/)$", re.MULTILINE)
PAGE_WITHIN_MS = 60_000
# Software draws the picture, which takes a browser's whole attention.
expect.set_options(timeout=30_000)


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
def chromium_program() -> Iterator[Browser]:
    with browser() as started:
        yield started


@pytest.fixture
def chromium(chromium_program: Browser) -> Iterator[Browser]:
    yield chromium_program
    # A page that is left open would connect to that of the next test.
    for context in chromium_program.contexts:
        context.close()


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
    page = open_page(chromium, address)
    page.set_default_timeout(PAGE_WITHIN_MS)
    return page


def slider_of(page: Page, joint: str) -> Locator:
    row = page.get_by_text(joint, exact=True).locator("xpath=ancestor::div[2]")
    slider = row.get_by_role("slider")
    expect(slider).to_be_visible(timeout=PAGE_WITHIN_MS)
    return slider


def drag_to_the_right(page: Page, slider: Locator) -> None:
    slider.hover()  # it stands still by then
    box = slider.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.down()
    page.mouse.move(x + 30, y, steps=3)
    page.mouse.up()


def moved_by_dragging(ros: RosGraph, page: Page, slider: Locator, joint: str) -> Any:
    """The state of a robot whose slider was dragged; a page under construction may miss it once."""

    last: list[float] = []

    def has_moved(state: Any) -> bool:
        # And stands still again: the mouse moves on in steps, with pauses on a busy machine.
        last.append(position_of(state, joint))
        return last[-1] > 0.3 and len(last) >= 8 and max(last[-8:]) - min(last[-8:]) < 1e-4

    for _ in range(3):
        drag_to_the_right(page, slider)
        with suppress(AssertionError):
            return ros.wait_for_message(JointState, "/joint_states", has_moved, timeout_s=10)
    raise AssertionError(f"{joint} does not move")


def unfold(folder: Locator, inside: Locator) -> None:
    """Open a folder of the page, which moves under the mouse while the page is built up."""
    for _ in range(3):
        folder.click()
        with suppress(AssertionError):
            expect(inside).to_be_visible(timeout=10_000)
            return
    raise AssertionError("the folder does not open")


def position_of(message, joint: str) -> float:
    return float(dict(zip(message.name, message.position, strict=False)).get(joint, 0.0))


def test_the_page_shows_joints_and_camera_of_the_robot_and_a_slider_moves_it(ros, chromium):
    pictures = ros.node.create_publisher(Image, "/cam/image_raw", 1)
    address = launched(ros, "display.yaml")
    assert "/rviz" in ros.run("node list").stdout.split()
    assert "rviz" in ros.run("ps").stdout
    page = opened(chromium, address)
    for name in ("joint_1", "joint_2", "joint_3", "joint_4"):
        expect(page.get_by_text(name, exact=True)).to_be_visible(timeout=PAGE_WITHIN_MS)
    # joint_5 follows joint_4
    expect(page.get_by_text("joint_5", exact=True)).to_have_count(0)
    slider = slider_of(page, "joint_1")
    state = moved_by_dragging(ros, page, slider, "joint_1")
    # What the page shows, /joint_states, /tf and forward kinematics are one and the same.
    position = position_of(state, "joint_1")
    expect(slider).to_have_attribute("aria-valuenow", re.compile(f"{position:.3f}"[:4]))
    model = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
    description = RobotDescription.from_urdf(expand_xacro(model))
    tree = SegmentTree(description, Joints.for_display(description, print))
    ((joint, expected),) = tree.transforms({"joint_1": position})

    def is_where_it_should_be(message) -> bool:
        return any(
            transform.child_frame_id == joint.child
            and transform.transform.rotation.z == pytest.approx(expected.rotation[2], abs=1e-6)
            for transform in message.transforms
        )

    ros.wait_for_message(TFMessage, "/tf", matching=is_where_it_should_be)
    eventually(lambda: is_shown(page, pictures))
    # A click on a node of the graph leads to its parameters.
    page.get_by_role("tab", name="Graph").click()
    node = page.locator('[data-teleopctl-click="graph node /robot_state_publisher"]')
    node.first.dispatch_event("click")
    page.get_by_role("button", name="Parameters", exact=True).click()
    expect(page.get_by_text("publish_frequency")).to_be_visible(timeout=PAGE_WITHIN_MS)


def is_shown(page: Page, pictures: Publisher) -> bool:
    """Publish a picture; return whether the page has shown one."""
    pictures.publish(Image(width=64, height=48, encoding="mono8", step=64, data=bytes(64 * 48)))
    return page.get_by_text("/cam/image_raw · 64 x 48").count() > 0


LAYOUT = """
version: 1
title: Mine
bar: [tools]
right: {panels: [[camera, log, topics, plot]]}
"""


@pytest.mark.nightly
def test_a_camera_is_shown_while_it_is_seen(ros, chromium):
    layout = ros.folder / "mine.yaml"
    layout.write_text(LAYOUT)
    pictures = ros.node.create_publisher(Image, "/cam/image_raw", 1)
    page = opened(chromium, run_page(ros, "--layout", str(layout)))
    eventually(lambda: is_shown(page, pictures), PAGE_WITHIN_MS / 1000)
    page.get_by_role("tab", name="Log").click()
    expect(page.get_by_role("tab", name="Log")).to_have_attribute("aria-selected", "true")
    eventually(lambda: ros.node.count_subscribers("/cam/image_raw") == 0)
    page.get_by_role("tab", name="Camera").click()
    eventually(lambda: ros.node.count_subscribers("/cam/image_raw") == 1)


@pytest.mark.nightly
def test_each_browser_finds_its_panels_again(ros, chromium):
    ros.node.create_publisher(Image, "/cam/image_raw", 1)
    layout = ros.folder / "mine.yaml"
    layout.write_text(LAYOUT)
    page = opened(chromium, run_page(ros, "--layout", str(layout)))
    page.get_by_role("button", name="Layout", exact=True).click()
    box = page.get_by_text("Topics", exact=True).last.locator("xpath=ancestor::div[3]")
    box.get_by_role("checkbox").first.click()
    expect(page.get_by_role("tab", name="Topics")).to_have_count(0)
    page.get_by_role("button", name="Close").click()
    # Plots and the log's filters are each browser's own.
    page.get_by_role("tab", name="Plot").click()
    expression = page.get_by_text("Expression", exact=True).locator("xpath=ancestor::div[2]")
    expression.locator("input").fill("2 * /cam/image_raw/height")
    page.keyboard.press("Enter")
    expect(page.locator("label", has_text="Plot 1")).to_be_visible()
    page.get_by_role("tab", name="Log").click()
    page.get_by_role("combobox").first.click()
    page.get_by_role("option", name="Fatal", exact=True).click()
    other = opened(chromium, page.url)
    expect(other.get_by_role("tab", name="Topics")).to_have_count(1)
    other.get_by_role("tab", name="Log").click()
    expect(other.get_by_role("combobox").first).to_have_value("Info")
    other.get_by_role("tab", name="Plot").click()
    expect(other.get_by_text("Expression", exact=True)).to_be_visible()
    expect(other.locator("label", has_text="Plot 1")).to_have_count(0)
    other.close()
    key = "viser-user:teleopctl.workspace"
    page.wait_for_function(
        f"""(() => {{
          const kept = JSON.parse(localStorage.getItem('{key}'));
          return kept?.panels.plot && !kept.right.panels.flat().includes('topics');
        }})()"""
    )
    page.reload()
    page.get_by_role("tab", name="Log").click()
    expect(page.get_by_role("combobox").first).to_have_value("Fatal")
    page.get_by_role("tab", name="Plot").click()
    expect(page.locator("label", has_text="Plot 1")).to_be_visible()
    expect(page.get_by_role("tab", name="Topics")).to_have_count(0)


FORMS = """
version: 1
title: Forms
right: {panels: [[send]]}
"""


@pytest.mark.nightly
def test_a_message_a_call_and_a_goal_are_sent_by_their_forms(ros, chromium):
    received: list[object] = []
    ros.node.create_subscription(String, "/words", lambda words: received.append(words.data), 10)

    def switch(request, response):
        received.append(request.data)
        response.success, response.message = True, "switched <b>on</b>"
        return response

    def count(goal):
        received.append(goal.request.order)
        goal.succeed()
        return Fibonacci.Result(sequence=[0, 1, 1, 2])

    ros.node.create_service(SetBool, "/switch", switch)
    server = ActionServer(ros.node, Fibonacci, "/count", count)
    layout = ros.folder / "forms.yaml"
    layout.write_text(FORMS)
    page = opened(chromium, run_page(ros, "--layout", str(layout)))

    def open_form(target: str, field: str) -> Locator:
        choice = page.get_by_role("combobox").first
        choice.click()
        choice.fill(target)
        page.get_by_role("option", name=target, exact=True).click()
        row = page.get_by_text(field, exact=True).locator("xpath=ancestor::div[1]/..")
        return row.locator("input").first

    open_form("topic /words", "data").fill("good day")
    page.get_by_role("button", name="Publish", exact=True).click()
    eventually(lambda: received == ["good day"])
    expect(page.get_by_text("Published to 1 subscription.")).to_be_visible()
    open_form("service /switch", "data").check(force=True)
    page.get_by_role("button", name="Call", exact=True).click()
    # What comes from outside is text.
    expect(page.get_by_text("switched <b>on</b>")).to_be_visible()
    open_form("action /count", "order").fill("3")
    page.get_by_role("button", name="Send goal", exact=True).click()
    expect(page.get_by_text("The goal succeeded.")).to_be_visible()
    assert received == ["good day", True, 3]
    server.destroy()


@pytest.mark.nightly
def test_in_simulation_sliders_and_buttons_drive_the_controllers(ros, chromium):
    page = opened(chromium, launched(ros, "sim.yaml", "camera:=false"))
    moved_by_dragging(ros, page, slider_of(page, "joint_1"), "joint_1")
    page.get_by_role("tab", name="Controllers").click()
    page.get_by_role("button", name="Deactivate").first.click()

    def states():
        return ros.run("control list_controllers").stdout.split()

    eventually(lambda: "inactive" in states())
    page.get_by_role("button", name="Activate", exact=True).first.click()
    eventually(lambda: "inactive" not in states())


@pytest.mark.nightly
def test_nothing_is_listened_to_while_nobody_looks(ros, tmp_path):
    address = launched(ros, "display.yaml")

    def listens() -> bool:
        topics = dict(ros.node.get_subscriber_names_and_types_by_node("rviz", "/"))
        return "/joint_states" in topics or "/tf" in topics

    ros.wait_for_nodes("/rviz")
    assert not listens()
    with window(address, tmp_path / "browser") as seen:
        eventually(listens, PAGE_WITHIN_MS / 1000)
        seen.cover()
        eventually(lambda: not listens())
        seen.uncover()
        eventually(listens)
    eventually(lambda: not listens())


@pytest.mark.nightly
def test_a_view_of_rviz_is_shown_and_saved_where_it_was(ros, chromium):
    view = ros.folder / "mine.rviz"
    view.write_text(VIEW)
    ros.launch("display.yaml")
    page = opened(chromium, run_page(ros, "-d", str(view), "--fullscreen"))
    page.get_by_role("tab", name="Scene").click()
    unfold(page.get_by_text("Frames of mine"), page.get_by_text("Marker Scale"))
    page.get_by_role("button", name="Save view").click()
    eventually(lambda: view.read_text() not in ("", VIEW))  # it is empty while it is written
    saved = yaml.safe_load(view.read_text())["Visualization Manager"]
    before = yaml.safe_load(VIEW)["Visualization Manager"]
    assert saved["Displays"] == before["Displays"]
    assert saved["Global Options"]["Fixed Frame"] == "base_plate"
    assert saved["Views"]["Current"]["Distance"] == pytest.approx(1.5, abs=0.01)
    assert "Odd" in page_log(ros)
    assert "Without effect on the page: --fullscreen" in page_log(ros)


@pytest.mark.nightly
def test_without_a_viewer_there_is_no_page(ros):
    done = ros.run(["launch", "--detach", "display.yaml", "viewer:=false"], 60)
    assert ADDRESS.search(done.stdout) is None
    assert "/rviz" not in ros.run("node list").stdout.split()


@pytest.mark.parametrize("words", ["-d missing.rviz", "--port 99999"])
def test_a_page_that_cannot_be_opened_says_why_and_nothing_else(ros, words):
    done = ros.run(f"run rviz2 rviz2 {words}")
    assert (done.returncode, done.stdout) == (1, "")
    assert words.split()[1] in done.stderr


def newest_transform_s(ros: RosGraph, frame: str) -> float:
    """The newest stamp that the page has of a frame."""
    answer = ros.run("service call /tf2_frames tf2_msgs/srv/FrameGraph").stdout
    found = re.search(rf"{frame}: .*?most_recent_transform: ([\d.]+)", answer, re.DOTALL)
    return float(found[1]) if found else -1.0


@pytest.mark.nightly
def test_a_display_beside_a_simulation_leaves_no_false_picture(ros, chromium):
    opened(chromium, launched(ros, "sim.yaml", "camera:=false"))
    eventually(lambda: newest_transform_s(ros, "base_plate") > 0.0, 30)
    done = ros.run(["launch", "--detach", "display.yaml", "viewer:=false"], 60)
    assert done.returncode == 0, done.stderr
    (warning,) = [line for line in done.stderr.splitlines() if line.startswith("WARNING")]
    assert "run already: /robot_state_publisher." in warning
    assert "`teleopctl stop sim`" in warning
    log = "logs sim"
    eventually(lambda: "Left out transforms of /robot_state_publisher" in ros.run(log).stdout, 30)
    assert ros.run("stop display").returncode == 0
    before_s = newest_transform_s(ros, "base_plate")
    assert before_s < 1e6  # simulated seconds, and not those of the wall
    eventually(lambda: newest_transform_s(ros, "base_plate") > before_s)
    said = ros.run(log).stdout
    assert said.count("Left out transforms") == 1
    assert "TF_OLD_DATA" not in said


@pytest.mark.nightly
def test_the_page_is_reset_as_rviz_is(ros, chromium):
    page = opened(chromium, launched(ros, "display.yaml"))
    eventually(lambda: newest_transform_s(ros, "base_plate") > 0.0, 30)
    ros.run("stop display/joint_state_publisher-2")
    assert newest_transform_s(ros, "base_plate") > 0.0  # the last that came
    page.keyboard.press("r")
    eventually(lambda: newest_transform_s(ros, "base_plate") < 0.0)
    page.get_by_role("tab", name="Scene").click()
    page.get_by_role("button", name="Reset", exact=True).click()
    assert ros.run("service call /rviz/reset_time std_srvs/srv/Empty").returncode == 0
