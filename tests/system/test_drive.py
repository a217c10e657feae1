"""``teleopctl drive``: a robot that a hand drives on a page."""

import contextlib
import json
import re
import socket
import sys
import threading
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from teleopctl.interfaces import get_message
from teleopctl.node import StopButton
from teleopctl.testing import eventually
from tests import ROOT
from tests.samples import is_nightly
from tests.system.browser import browser, open_page
from tests.system.driving import FAKE_GAMEPAD, driver, hand_of

MODEL = str(ROOT / "robot/urdf/teleop.urdf.xacro")


@contextlib.contextmanager
def held(connection, **hands):
    """Send a state of the hands at 50 Hz, as the page does, then let go of it."""
    done = threading.Event()

    def send():
        for sequence in range(1, 100_000):
            message = {"type": "hands", "sequence": sequence, **hands}
            connection.send(json.dumps(message))
            if done.wait(0.02):
                connection.send(json.dumps({"type": "hands", "sequence": sequence + 1}))
                return

    thread = threading.Thread(target=send)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


class States:
    """States that the page gets, read on a thread; the last one counts."""

    def __init__(self, connection):
        self.last: dict[str, Any] = {}
        threading.Thread(target=self._read, args=(connection,), daemon=True).start()

    def _read(self, connection):
        with contextlib.suppress(ConnectionClosed):
            for text in connection:
                message = json.loads(text)
                if message["type"] == "state":
                    self.last = message


@pytest.fixture
def drive(ros):
    """The command, with the address of its page."""
    process = ros.spawn("drive --port 0 --no-open")
    address = process.wait_for_line(r"^Mouse: +(\S+/drive) ")[1]
    for name in ("Keys", "Gamepad", "Phone"):
        process.wait_for_line(rf"^{name}:")
    yield process, address
    process.interrupt()
    assert process.wait() == 0


def is_3d_page(url):
    return urlsplit(url).path == "/"


def look_at_the_page(ros, address, states):
    """What a person finds on the page in a browser: words, the camera, focus, a reload."""
    image = get_message("sensor_msgs/msg/Image")
    pixels = image(width=8, height=6, encoding="rgb8", step=24, data=bytes(144))
    camera = ros.node.create_publisher(image, "/front/image_raw", 1)
    with browser() as chromium:
        page = open_page(chromium, "about:blank")
        # Without the 3D view, whose pictures are drawn by the processor here.
        page.route(is_3d_page, lambda route: route.abort())
        page.goto(address)
        page.locator("#status", has_text="the robot moves until you let go").wait_for()
        assert page.locator("#who").text_content() == "· not driven"
        # Three joints turn nothing.
        assert not page.locator("#pad_tilt").is_visible()
        assert not page.locator("kbd[data-key=KeyI]").is_visible()

        eventually(lambda: camera.get_subscription_count() == 1)
        picture = page.locator("#camera_picture")

        def is_seen():
            camera.publish(pixels)
            return picture.evaluate("image => image.naturalWidth") > 0

        eventually(is_seen)
        page.locator("#camera_hide").click()
        eventually(lambda: camera.get_subscription_count() == 0)
        page.locator("#camera_show").click()
        eventually(lambda: camera.get_subscription_count() == 1)
        page.locator("#camera_hide").click()

        page.get_by_role("button", name="100 %").click()
        view = page.locator("#view").bounding_box()
        page.keyboard.down("ArrowUp")
        page.locator("#status", has_text="Moving").wait_for()
        # What a hand drags stays below it.
        assert page.locator("#view").bounding_box() == view
        page.locator("#status", has_text="stretched to its end: move back").wait_for()
        assert page.locator("#view").bounding_box() == view
        assert page.locator("#who").text_content() == "· you drive"
        assert re.match(
            r"forward · 0.40 m/s, 0.80 rad/s · servo: .*singularity",
            str(page.locator("#now").text_content()),
        )
        # A reload is a release, which the page that goes still reports.
        page.reload()
        eventually(lambda: not states.last["is_moving"])
        page.keyboard.up("ArrowUp")
        page.locator("#status", has_text="the robot moves until you let go").wait_for()

        # Space stops wherever the focus is, and presses nothing.
        page.get_by_role("button", name="25 %").focus()
        page.keyboard.press("Space")
        eventually(lambda: states.last["stopped_by"] == ["/teleop_page"])
        assert states.last["speed_step"] == 2
        page.get_by_role("button", name="Release robot").click()
        eventually(lambda: not states.last["stopped_by"])

        assert page.get_by_role("link", name="3D page").get_attribute("href") == "/"
        if is_nightly():
            page.unroute(is_3d_page)
            page.get_by_role("link", name="3D page").click()
            page.get_by_role("link", name="Drive", exact=True).click()
            page.locator("#robot", has_text="Drive teleop").wait_for()


def test_a_key_that_is_held_moves_the_gripper_until_its_release(ros, drive):
    _, address = drive
    positions: dict[str, float] = {}
    ros.node.create_subscription(
        get_message("sensor_msgs/msg/JointState"),
        "/joint_states",
        lambda message: positions.update(zip(message.name, message.position, strict=True)),
        10,
    )
    with connect(f"{address.replace('http', 'ws')}/socket") as page:
        states = States(page)
        eventually(lambda: states.last.get("opening") is not None and positions)
        eventually(lambda: not states.last["problem"])
        assert states.last["robot"] == "teleop"
        with held(page, keys=["ArrowRight", "KeyE"]):
            eventually(lambda: positions["joint_1"] < -0.1 and states.last["opening"] > 0.2)
            ros.run(
                "topic pub --once /arm_controller/commands std_msgs/msg/Float64MultiArray "
                "'{data: [0.5, 0, 0]}'"
            )
            who = ros.run("drive --who").stdout
            # While the hand holds it: two seconds later it ends by itself.
            assert ros.run("drive --release").stdout.startswith("Ended: /teleop_page")
            eventually(lambda: states.last["holder"] is None)
        assert re.match(r"/teleop_page \(keys, on .+\) drives since [\d:]+\n", who)
        assert (
            "The command on ~/commands is refused: /teleop_page"
            in ros.run("logs mujoco_sim").stdout
        )
        eventually(lambda: not states.last["is_moving"])
        # Nobody says that it is released: silence does. The other way: it may be at its limit.
        before = positions["joint_1"]
        page.send(json.dumps({"type": "hands", "sequence": 10**6, "keys": ["ArrowLeft"]}))
        eventually(lambda: positions["joint_1"] > before + 1e-3)
        eventually(lambda: not states.last["is_moving"])
        page.send(json.dumps({"type": "press", "action": "stop"}))
        eventually(lambda: states.last["stopped_by"] == ["/teleop_page"])
        page.send(json.dumps({"type": "press", "action": "release_stop"}))
        eventually(lambda: not states.last["stopped_by"])
        # By another node, which is asked to let go.
        stop = StopButton(ros.node)
        stop.press()
        eventually(lambda: states.last["stopped_by"])
        page.send(json.dumps({"type": "press", "action": "release_stop"}))
        eventually(lambda: not states.last["stopped_by"])
        look_at_the_page(ros, address, states)


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["nowhere.urdf"], "There is no file 'nowhere.urdf'"),
        ([MODEL, MODEL], "is a second robot"),
        (["--open", "--no-open"], "--open and --no-open exclude each other"),
        (["--device", "gamepat"], "There is no teleop device 'gamepat'"),
        pytest.param(
            ["--device", "gamepad"],
            "No gamepad is attached",
            marks=pytest.mark.skipif(
                sys.platform != "linux" or any(Path("/dev/input").glob("js*")),
                reason="a gamepad is attached, or pygame looks for one",
            ),
        ),
        (
            ["--device", "joy", "--mapping", "mine.yaml"],
            "The mapping mine.yaml cannot be read: No such file or directory",
        ),
        (["--mapping", "mine.yaml"], "--mapping is for --device"),
        (["--leader", "/leader", "-d"], "--device shows its state in this terminal"),
    ],
)
def test_wrong_words_are_refused(ros, words, problem):
    done = ros.run(["drive", *words])
    assert done.returncode in (1, 2)
    assert problem in done.stderr
    assert "Mouse:" not in done.stdout


def runs(ros):
    """Names and texts of what runs in the background, the router aside."""
    return [line for line in ros.run("ps").stdout.splitlines()[1:] if "router" not in line]


def test_a_robot_that_does_not_load_leaves_nothing_behind(ros):
    file = ros.folder / "broken.urdf"
    file.write_text(
        '<robot name="broken"><link name="base"/><joint name="a" type="revolute">'
        '<parent link="base"/><child link="nowhere"/></joint></robot>',
        encoding="utf-8",
    )
    done = ros.run(["drive", str(file), "--no-open", "--port", "0"])
    assert done.returncode == 1
    assert "Joint 'a' is of type 'revolute' but it does not specify limits" in done.stderr
    assert runs(ros) == []


def test_a_page_that_does_not_start_ends_all_that_was_started(ros):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = ros.run(["drive", "--no-open", "--port", str(port)], 60)
    assert done.returncode == 1
    assert not re.search(r"Mouse:|Traceback|continues", done.stdout + done.stderr)
    assert f"{port}: another program listens there" in done.stderr
    assert "All of it has been ended; see `teleopctl logs drive`" in done.stderr
    assert runs(ros) == []


@pytest.mark.nightly
def test_a_launch_without_a_page_is_ended(ros):
    done = ros.run(["drive", "--no-open", "viewer:=false"], 60)
    assert done.returncode == 1
    assert "The launch starts no page (is it called with viewer:=false?)" in done.stderr
    assert runs(ros) == []


@pytest.mark.nightly
@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("handle", (900, 600)),
        ("keys", (1440, 900)),
        ("gamepad", (1440, 900)),
        ("pads", (390, 844)),
    ],
)
def test_the_cube_comes_into_the_bin(drive, name, size):
    with browser() as chromium, driver(MODEL) as person:
        width, height = size
        page = open_page(
            chromium, drive[1], width, height, FAKE_GAMEPAD if name == "gamepad" else ""
        )
        page.wait_for_function("document.getElementById('robot').textContent == 'Drive teleop'")
        person.wait()
        assert person.bring_cube(hand_of(name)(page, person))
