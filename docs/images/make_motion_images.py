"""Take the pictures of moving arms: ``python docs/images/make_motion_images.py [NAME…]``.

``pick.png`` is four moments of a pick, drawn from the recording of a run. ``planned_path.png`` and
``servo_stop.png`` are what the page shows beside ``move_group`` and servo. Needs the extra ``test``
(Playwright) and Chromium.
"""

from __future__ import annotations

import io
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Page, sync_playwright

import teleopctl
from teleopctl.interfaces import get_message
from teleopctl.testing import RosGraph, eventually

FOLDER = Path(__file__).parent
WIDE = (1700, 900)
# What is kept of the page: the robot, between the docks.
CLIP = {"x": 330, "y": 100, "width": 1010, "height": 640}
WAIT_MS = 90_000
SEED = 1
FRAME = (640, 440)


@contextmanager
def graph() -> Iterator[RosGraph]:
    """A graph of its own, in a folder of its own."""
    with tempfile.TemporaryDirectory() as folder, RosGraph(Path(folder)) as ros:
        yield ros


def draw_pick(file: Path) -> None:
    """Draw four moments of a recorded pick: before, the grasp, on the way, and in the bin."""
    from teleopctl.sim import choose_backend

    choose_backend()
    import mujoco

    from teleopctl.packages import package_share
    from teleopctl.robot import expand_xacro
    from teleopctl.sim import simulate

    states, cubes = _recorded_pick()
    urdf = expand_xacro(package_share("teleop_description") / "urdf" / "teleop.urdf.xacro")
    world = package_share("teleopctl") / "worlds" / "pick_and_place.yaml"
    made = simulate(urdf, world=str(world), control_period_ns=100_000_000).model
    model, (cube,) = made.mj_model, made.free_bodies
    model.vis.global_.offwidth, model.vis.global_.offheight = 2 * FRAME[0], 2 * FRAME[1]
    model.vis.global_.fovy = 35.0
    data = mujoco.MjData(model)
    camera = mujoco.MjvCamera()
    camera.lookat[:] = (-0.45, 0.75, 0.45)
    camera.distance, camera.azimuth, camera.elevation = 4.4, 230.0, -20.0
    options = mujoco.MjvOption()
    options.geomgroup[0] = 0  # collision shapes
    frames = []
    with mujoco.Renderer(model, 2 * FRAME[1], 2 * FRAME[0]) as renderer:
        for time_ns in _moments(states, cubes):
            for joint, position in states[time_ns].items():
                data.joint(joint).qpos = position
            data.joint(cube.joint).qpos[:] = cubes[time_ns]
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, camera, options)
            picture = Image.fromarray(renderer.render())
            frames.append(picture.resize(FRAME, Image.Resampling.LANCZOS))
    whole = Image.new("RGB", (2 * FRAME[0], 2 * FRAME[1]))
    for number, frame in enumerate(frames):
        whole.paste(frame, (number % 2 * FRAME[0], number // 2 * FRAME[1]))
    save(whole, file)


# Any: messages, whose classes are made at run time.
def _recorded_pick() -> tuple[dict[int, dict[str, float]], dict[int, list[float]]]:
    """Return joint positions, and poses of the cube (x y z w x y z), by simulated time."""
    with graph() as ros:
        run = ros.spawn(
            "launch pick_and_place.yaml camera:=false viewer:=false times:=1 "
            f"seed:={SEED} real_time_factor:=0 record:=pick"
        )
        run.wait_for_line("1 of 1 cubes are in the bin")
        run.interrupt()
        run.wait()
        states: dict[int, dict[str, float]] = {}
        cubes: dict[int, list[float]] = {}
        topics = ["/mujoco_sim/joint_states", "/mujoco_sim/free_joint_states"]
        for each in teleopctl.read_bag(ros.folder / "pick", topics):
            message: Any = each.message
            stamp = message.header.stamp
            time_ns = stamp.sec * 1_000_000_000 + stamp.nanosec
            if each.topic == topics[0]:
                states[time_ns] = dict(zip(message.name, message.position, strict=True))
            else:
                pose = message.free_joints[0].pose.pose
                at, turn = pose.position, pose.orientation
                cubes[time_ns] = [at.x, at.y, at.z, turn.w, turn.x, turn.y, turn.z]
    return states, cubes


def _moments(states: dict[int, dict[str, float]], cubes: dict[int, list[float]]) -> list[int]:
    times = sorted(states.keys() & cubes.keys())
    lifted = next(time for time in times if cubes[time][2] > 0.2)
    closing = max(time for time in times if time < lifted and states[time]["joint_4"] < -1.4)
    carried = [time for time in times if cubes[time][2] > 0.4]
    return [closing - 800_000_000, lifted, carried[len(carried) // 2], times[-1]]


def show_path(page: Page, ros: RosGraph) -> None:
    """Let the arm move slowly past a column of the planning scene; the path is drawn as a trail."""
    ros.run("move --joints 0.9,-0.75,0.2 --speed 0.05")
    ros.run(
        "topic pub --once /collision_object moveit_msgs/msg/CollisionObject "
        "'{id: column, header: {frame_id: world}, pose: {position: {x: -0.1, y: 1.25, z: 0.55}}, "
        "primitives: [{type: 1, dimensions: [0.2, 0.2, 1.1]}]}'"
    )
    page.get_by_text("MotionPlanning", exact=True).first.dispatch_event("click")
    trail = page.get_by_text("Planned Path: Show Trail").first
    trail.locator("xpath=ancestor::*[.//input][1]//input").first.dispatch_event("click")
    page.get_by_text("MotionPlanning", exact=True).first.dispatch_event("click")
    ros.spawn("move --joints -0.7,-0.75,0.2 --speed 0.002")
    page.wait_for_timeout(20_000)


def show_stop(page: Page, ros: RosGraph) -> None:
    """Steer the closed gripper down until the table stops it."""
    ros.run("move --joints 0.15,-0.3,-0.2 --speed 0.05")
    statuses: list[str] = []
    ros.node.create_subscription(
        get_message("moveit_msgs/msg/ServoStatus"),
        "/servo_node/status",
        lambda status: statuses.append(status.message),
        10,
    )
    ros.spawn(
        "topic pub --rate 50 /servo_node/delta_twist_cmds geometry_msgs/msg/TwistStamped "
        "'{header: {frame_id: world}, twist: {linear: {z: -0.9}}}'"
    )
    eventually(lambda: any("0.002 m from" in text for text in statuses))
    page.wait_for_timeout(6_000)


def photograph(file: Path, show: Callable[[Page, RosGraph], None]) -> None:
    """Save what the page shows of a simulation with move_group and servo."""
    program = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))), None)
    arguments = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"]
    with sync_playwright() as playwright, graph() as ros:
        browser = playwright.chromium.launch(
            executable_path=program, args=[*arguments, "--enable-unsafe-swiftshader"]
        )
        words = "launch --detach sim.yaml camera:=false motion:=true viewer:=true"
        address = re.findall(r"http://\S+", ros.run(words, 90).stdout)[-1]
        page = browser.new_page(viewport={"width": WIDE[0], "height": WIDE[1]})
        page.set_default_timeout(WAIT_MS)
        page.goto(address)
        page.get_by_text("joint_1", exact=True).first.wait_for()
        page.wait_for_timeout(8_000)
        # What the page says of the browser without a graphics card.
        close = page.locator(".mantine-Notification-closeButton")
        for _ in range(close.count()):
            close.first.click()
        show(page, ros)
        picture = Image.open(io.BytesIO(page.screenshot(clip=CLIP))).convert("RGB")  # type: ignore[arg-type]
        save(picture, file)
        browser.close()


def save(picture: Image.Image, file: Path) -> None:
    """Write a picture in few colours, so that the file is small."""
    picture.quantize(200, dither=Image.Dither.NONE).save(file, optimize=True)
    sys.stdout.write(f"{file}: {file.stat().st_size // 1000} kB\n")


PICTURES: dict[str, Callable[[Path], None]] = {
    "pick": draw_pick,
    "planned_path": lambda file: photograph(file, show_path),
    "servo_stop": lambda file: photograph(file, show_stop),
}

if __name__ == "__main__":
    for wanted in sys.argv[1:] or PICTURES:
        PICTURES[wanted](FOLDER / f"{wanted}.png")
