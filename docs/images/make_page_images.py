"""Take the pictures of the page: ``python docs/images/make_page_images.py [NAME…]``.

The arm runs in the simulator; a browser without a window opens the page, does what a person would
do, and is photographed. Needs the extra ``test`` (Playwright) and Chromium.
"""

from __future__ import annotations

import io
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from PIL import Image
from playwright.sync_api import Error, Page, ViewportSize, sync_playwright

from teleopctl.testing import RosGraph

FOLDER = Path(__file__).parent
LAPTOP: ViewportSize = {"width": 1440, "height": 900}
PHONE: ViewportSize = {"width": 390, "height": 844}
FILM_SIZE = (800, 500)
FILM_PICTURES = 60
FILM_PICTURE_MS = 333
# From one picture of the film to the next, in steps of 1 ms. The simulation stands still while a
# picture is taken, since software draws the page.
FILM_STEPS = 80
WAIT_MS = 60_000

# What the robot does, in simulated seconds: positions, and when.
Moves = tuple[tuple[tuple[float, ...], float], ...]
MOVES: Moves = (
    ((0.7, -0.5, 0.5), 1.0),
    ((-0.6, 0.3, -0.4), 2.4),
    ((0.0, 0.0, 0.0), 3.4),
)
OPEN: Moves = (((-0.8,), 0.5),)
# In the film it takes the cube from the table.
LIFT: Moves = (
    ((0.0, -0.77, 0.0), 1.2),
    ((0.0, -0.77, 0.0), 2.0),
    ((0.0, -0.3, 0.0), 2.8),
    ((0.7, -0.3, 0.0), 3.6),
    ((0.0, -0.3, 0.0), 4.4),
)
GRIP: Moves = (((-0.6,), 0.4), ((-0.6,), 1.4), ((0.0,), 1.8))


# What the sliders of a displayed robot publish.
SLIDERS = (
    "/joint_state_publisher_gui/joint_states",
    "sensor_msgs/msg/JointState",
    "{name: [joint_1, joint_2, joint_3, joint_4], position: [0.6, -0.4, 0.5, -0.6]}",
)
SINGLE = (
    *("page.webp", "page_phone.png", "page_head.png", "page_bag.png", "page_display.png"),
    "page_moved.png",
)


def command(ros: RosGraph, arm: Moves, gripper: Moves = OPEN) -> None:
    """Send the arm and the gripper along trajectories."""
    send(ros, "gripper_controller", "[joint_4]", gripper)
    send(ros, "arm_controller", "[joint_1, joint_2, joint_3]", arm)


def send(ros: RosGraph, controller: str, joints: str, moves: Moves) -> None:
    """Send one controller along a trajectory."""
    points = ", ".join(
        f"{{positions: {list(positions)}, time_from_start: "
        f"{{sec: {int(at)}, nanosec: {round(at % 1 * 1e9)}}}}}"
        for positions, at in moves
    )
    message = f"{{joint_names: {joints}, points: [{points}]}}"
    topic, type_name = f"/{controller}/joint_trajectory", "trajectory_msgs/msg/JointTrajectory"
    ros.run(["topic", "pub", "--once", topic, type_name, message])


def launch(ros: RosGraph, *words: str) -> str:
    """Launch in the background with the page, and return its address."""
    done = ros.run(["launch", "--detach", *words, "viewer:=true"], 90)
    if done.returncode:
        raise SystemExit(done.stderr)
    addresses: list[str] = re.findall(r"http://\S+", done.stdout)
    return addresses[-1]


def prepare(page: Page, address: str, joint: str = "joint_1") -> None:
    """Open the page, and wait until the robot stands there."""
    page.set_default_timeout(WAIT_MS)
    page.goto(address)
    # On a phone the sliders are in a section of the sheet, which is closed at first.
    page.get_by_role("button", name="Layout", exact=True).wait_for()
    if page.viewport_size != PHONE:
        page.get_by_text(joint, exact=True).wait_for()
    close_notifications(page)
    # Meshes are drawn some pictures after the sliders.
    page.wait_for_timeout(6_000)


def close_notifications(page: Page) -> None:
    """Close what the page tells of the browser without a graphics card."""
    close = page.locator(".mantine-Notification-closeButton")
    for _ in range(close.count()):
        # Without waiting until it stands still, which takes long where software draws.
        close.first.dispatch_event("click")


def photograph(page: Page, name: str) -> None:
    """Write what the page shows, in few colours so that the file is small."""
    picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    file = FOLDER / name
    picture.quantize(200, dither=Image.Dither.NONE).save(file, optimize=True)
    sys.stdout.write(f"{file}: {file.stat().st_size} bytes\n")


def tab(name: str, *steps: Callable[[Page], object]) -> Callable[[Page], None]:
    """What to do for a picture of a tab."""

    def show(page: Page) -> None:
        page.get_by_role("tab", name=name).click()
        for step in steps:
            step(page)
        page.mouse.move(20, 400)  # no tooltip
        page.wait_for_timeout(4_000)

    return show


def film(page: Page, ros: RosGraph) -> None:
    """Write the moving picture of README."""
    command(ros, LIFT, GRIP)
    pictures = []
    step = "/mujoco_sim/step_simulation mujoco_ros2_control_msgs/srv/StepSimulation"
    for _ in range(FILM_PICTURES):
        ros.run(["service", "call", *step.split(), f"{{steps: {FILM_STEPS}}}"])
        page.wait_for_timeout(1_000)
        shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
        pictures.append(shot.resize(FILM_SIZE, Image.Resampling.LANCZOS))
    file = FOLDER / "page.webp"
    pictures[0].save(
        file,
        save_all=True,
        append_images=pictures[1:],
        duration=FILM_PICTURE_MS,
        loop=0,
        quality=45,
        method=6,
    )
    sys.stdout.write(f"{file}: {file.stat().st_size} bytes\n")


def choose(label: str, option: str) -> Callable[[Page], None]:
    """Choose from a list."""

    def step(page: Page) -> None:
        page.get_by_role("combobox", name=label).click()
        page.get_by_role("option", name=option).first.click()

    return step


def plot(words: str) -> Callable[[Page], None]:
    """Plot the first field that is found by words."""

    def step(page: Page) -> None:
        # viser connects no label with its text fields.
        mark = page.locator('[data-teleopctl-panel="plot"]')
        mark.locator("xpath=following::input[1]").fill(words)
        page.locator('[data-teleopctl-click^="plot choose"]').first.click()

    return step


def press(name: str) -> Callable[[Page], None]:
    """Press a button."""
    return lambda page: page.get_by_role("button", name=name, exact=True).click()


def show_camera(page: Page) -> None:
    """Wait for the picture of the camera, which is shown by itself."""
    page.get_by_text("2304 x 1296").wait_for()


def enlarge_graph(page: Page) -> None:
    """Show the graph in the whole window, once the rates are measured."""
    page.wait_for_timeout(6_000)
    page.locator(".graph-picture").click(position={"x": 3, "y": 3})


def click_link(page: Page) -> None:
    """Click the arm above its base: the first of some points at which it is drawn."""
    found = page.get_by_text("revolute").first
    for x, y in ((590, 340), (575, 380), (600, 300), (560, 330)):
        page.mouse.move(x, y)
        page.wait_for_timeout(1_500)
        page.mouse.click(x, y)
        with suppress(Error):
            found.wait_for(timeout=8_000)
            return
    found.wait_for()


def show_frames(page: Page) -> None:
    """Switch on the TF display of the tab Scene, with the names of the frames."""
    page.get_by_text("TF", exact=True).first.dispatch_event("click")
    page.locator("input[type=checkbox]:visible").first.dispatch_event("click")


TABS: dict[str, Callable[[Page], None]] = {
    "page_joints.png": tab("Joints"),
    "page_camera.png": tab("Joints", show_camera),
    "page_plot.png": tab("Plot", plot("reference feedback arm_controller")),
    "page_graph.png": tab("Graph", choose("Topics with", "Types and rates"), enlarge_graph),
    "page_controllers.png": tab("Controllers"),
    "page_link.png": tab("Joints", click_link),
}


def own_robot(ros: RosGraph) -> Path:
    """Write the robot of the page on one's own robot, and return its file."""
    text = (FOLDER.parent / "own_robot.md").read_text(encoding="utf-8")
    file = ros.folder / "head.urdf"
    file.write_text("<robot" + text.partition("<robot")[2].partition("```")[0], encoding="utf-8")
    return file


def show_bag(page: Page, ros: RosGraph) -> None:
    """Record a session in which the arm takes the cube, and open it at a moment of it."""
    session = ros.launch("sim.yaml", "record:=session")
    command(ros, LIFT, GRIP)
    page.wait_for_timeout(5_000)
    session.stop()
    view = ros.spawn("bag view session --start-paused --port 0")
    found = view.wait_for_line(r"(http://\S+)")
    page.set_default_timeout(WAIT_MS)
    page.goto(found[1])
    page.get_by_role("button", name="Play", exact=True).wait_for()
    page.wait_for_timeout(4_000)
    close_notifications(page)
    # A click beside the thumb, as a person would do it.
    box = page.get_by_role("slider").first.locator("xpath=../..").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.75 * box["width"], box["y"] + box["height"] / 2)
    page.mouse.move(20, 400)
    page.wait_for_timeout(6_000)


@contextmanager
def graph() -> Iterator[RosGraph]:
    """A graph of its own, in a folder of its own."""
    with tempfile.TemporaryDirectory() as folder, RosGraph(Path(folder)) as ros:
        yield ros


def main(names: list[str]) -> None:
    """Take the pictures that are named, or all."""
    wanted = names or [*SINGLE, *TABS]
    program = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))), None)
    arguments = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=program, args=[*arguments, "--enable-unsafe-swiftshader"]
        )
        if "page.webp" in wanted:
            with graph() as ros:
                address = launch(ros, "sim.yaml", "camera:=false", "paused:=true")
                page = browser.new_page(viewport=LAPTOP)
                prepare(page, address)
                film(page, ros)
                page.close()
        if "page_head.png" in wanted:
            with graph() as ros:
                address = launch(ros, "display.yaml", f"model:={own_robot(ros)}")
                page = browser.new_page(viewport=LAPTOP)
                prepare(page, address, "pan")
                press("Randomize")(page)
                page.wait_for_timeout(5_000)
                photograph(page, "page_head.png")
                page.close()
        if "page_display.png" in wanted:
            with graph() as ros:
                address = launch(ros, "display.yaml")
                page = browser.new_page(viewport=LAPTOP)
                prepare(page, address)
                ros.run(["topic", "pub", "--once", *SLIDERS])
                tab("Scene", show_frames)(page)
                photograph(page, "page_display.png")
                page.close()
        if "page_bag.png" in wanted:
            with graph() as ros:
                page = browser.new_page(viewport=LAPTOP)
                show_bag(page, ros)
                photograph(page, "page_bag.png")
                page.close()
        tabs = [name for name in TABS if name in wanted]
        if tabs or {"page_phone.png", "page_moved.png"} & set(wanted):
            with graph() as ros:
                address = launch(ros, "sim.yaml", "camera:=true")
                command(ros, (((0.5, -0.4, 0.6), 1.0),))
                if "page_phone.png" in wanted:
                    phone = browser.new_page(viewport=PHONE)
                    prepare(phone, address)
                    photograph(phone, "page_phone.png")
                    phone.close()
                if "page_moved.png" in wanted:
                    page = browser.new_page(viewport=LAPTOP)
                    prepare(page, address)
                    photograph(page, "page_moved.png")
                    page.close()
                for name in tabs:
                    page = browser.new_page(viewport=LAPTOP)
                    prepare(page, address)
                    TABS[name](page)
                    command(ros, MOVES)
                    page.wait_for_timeout(5_000)
                    photograph(page, name)
                    page.close()
        browser.close()


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except subprocess.TimeoutExpired as error:
        raise SystemExit(str(error)) from error
