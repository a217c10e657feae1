"""Draw the pictures of the documentation: ``python docs/images/make_images.py [NAME…]``.

``teleop_arm.png`` is the simulator's own model of the arm, drawn from outside. ``camera.png`` is
what the robot's own camera sees in a running simulation, made by the commands of the page.
``sensors.png`` is what the sensors of the robot in ``docs/sensors.md`` measure.
"""

import math
import os
import socket
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from PIL import Image

from teleopctl.sim import choose_backend

FOLDER = Path(__file__).parent
POSE = {"joint_1": -0.7, "joint_2": -0.3, "joint_3": 0.0, "joint_4": -0.6, "joint_5": 0.6}
# Where the arm holds its open gripper around the cube, in front of its camera.
CAMERA_GOAL = {"joint_1": 0.0, "joint_2": -0.77, "joint_3": 0.0, "joint_4": -0.6}
DEADLINE_S = 60.0


def draw_arm(file: Path) -> None:
    """Draw the whole arm, in three-quarter view, twice as large and then reduced."""
    choose_backend()
    import mujoco

    from teleopctl.mujoco_model import build_model
    from teleopctl.packages import package_share
    from teleopctl.robot import RobotDescription, expand_xacro

    urdf = expand_xacro(package_share("teleop_description") / "urdf" / "teleop.urdf.xacro")
    model = build_model(RobotDescription.from_urdf(urdf)).mj_model
    width, height = 1000, 680
    model.vis.global_.offwidth, model.vis.global_.offheight = 2 * width, 2 * height
    model.vis.global_.fovy = 35.0
    model.vis.quality.offsamples = 8
    model.vis.quality.shadowsize = 8192

    data = mujoco.MjData(model)
    for joint, position in POSE.items():
        data.joint(joint).qpos = position
    mujoco.mj_forward(model, data)

    camera = mujoco.MjvCamera()
    camera.lookat[:] = (0.1, 0.4, 0.78)
    camera.distance, camera.azimuth, camera.elevation = 3.5, 200.0, -14.0
    options = mujoco.MjvOption()
    options.geomgroup[0] = 0  # collision shapes
    with mujoco.Renderer(model, 2 * height, 2 * width) as renderer:
        renderer.update_scene(data, camera, options)
        picture = Image.fromarray(renderer.render())
    _save(picture.resize((width, height), Image.Resampling.LANCZOS), file)


def photograph(file: Path) -> None:
    """Save what the robot's own camera sees of the moved arm."""
    with socket.create_server(("localhost", 0)) as probe:
        port = probe.getsockname()[1]
    with tempfile.TemporaryDirectory() as folder:
        # A graph of its own: whatever else runs on this machine is not disturbed.
        os.environ["TELEOPCTL_ROUTER"] = f"tcp/localhost:{port}"
        os.environ["TELEOPCTL_RUNTIME_DIR"] = f"{folder}/run"
        os.environ["ROS_LOG_DIR"] = f"{folder}/log"
        try:
            teleopctl("launch", "sim.yaml", "quality:=full", "viewer:=false", "--detach")
            _move_to(CAMERA_GOAL)
            teleopctl("camera", "save", str(file))
        finally:
            teleopctl("stop", "--all")
    _save(Image.open(file).resize((960, 540), Image.Resampling.LANCZOS), file)


def measure(file: Path) -> None:
    """Draw what a camera, a depth camera, a segmentation camera and a lidar have measured."""
    choose_backend()
    import numpy as np

    from teleopctl.sim import CameraRenderer, simulate
    from teleopctl.sim.cameras.channel import palette
    from teleopctl.sim.cameras.renderer import FULL

    page = (FOLDER.parent / "sensors.md").read_text(encoding="utf-8")
    urdf = page.split("<!-- station.urdf -->")[1].split("```")[0].strip()
    made = simulate(urdf, control_period_ns=10_000_000)
    model, (front, *_) = made.model, made.model.cameras
    renderer = CameraRenderer(model, model.cameras, FULL)
    renderer.place({})
    colours = np.zeros((front.height, front.width, 3), np.uint8)
    depths = renderer.colours_and_depths("front", colours)
    shades = np.clip(255.0 * (1.0 - (depths - 1.0) / 3.0), 0, 255).astype(np.uint8)
    labels = palette(model.mj_model.nbody)[renderer.labels("names")]
    renderer.close()
    panels = [colours, np.repeat(shades[..., None], 3, -1), labels, _scan(made)]
    _save(Image.fromarray(np.hstack(panels)), file)


def _scan(made: Any) -> Any:
    """A scan from above, 80 pixels a metre; the robot is left of the middle and looks right."""
    import numpy as np

    from teleopctl.interfaces import get_message

    lidar = made.sensors[0]
    scan = get_message(lidar.message_type)()
    lidar.read(*made.simulation.observe(), scan)
    panel = np.full((240, 320, 3), 255, np.uint8)
    panel[117:123, 77:83] = (0, 0, 0)
    for index, distance in enumerate(scan.ranges):
        if math.isfinite(distance):
            angle = scan.angle_min + index * scan.angle_increment
            column = round(80 + 80 * distance * math.cos(angle))
            row = round(120 - 80 * distance * math.sin(angle))
            panel[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2] = (200, 30, 30)
    return panel


def teleopctl(*words: str) -> None:
    """Run the command line."""
    subprocess.run([sys.executable, "-m", "teleopctl", *words], check=True)


def _move_to(goal: dict[str, float]) -> None:
    """Move the arm and wait until it has arrived."""
    from teleopctl import node as ros
    from teleopctl.interfaces import get_message

    arm = [name for name in goal if name != "joint_4"]
    point = f"{{positions: {[goal[name] for name in arm]}, time_from_start: {{sec: 1}}}}"
    topic = "/arm_controller/joint_trajectory"
    trajectory = f"{{joint_names: {arm}, points: [{point}]}}"
    teleopctl("topic", "pub", "--once", topic, "trajectory_msgs/msg/JointTrajectory", trajectory)
    topic, fingers = "/gripper_controller/commands", f"{{data: [{goal['joint_4']}]}}"
    teleopctl("topic", "pub", "--once", topic, "std_msgs/msg/Float64MultiArray", fingers)

    ros.init()
    watcher = ros.Node("photographer")
    arrived: Any = ros.Future()

    def on_state(state: Any) -> None:
        now = dict(zip(state.name, state.position, strict=True))
        if not arrived.done() and all(
            math.isclose(now[name], position, abs_tol=1e-3) for name, position in goal.items()
        ):
            arrived.set_result(True)

    try:
        watcher.create_subscription(
            get_message("sensor_msgs/msg/JointState"), "/joint_states", on_state, 10
        )
        ros.spin_until_future_complete(watcher, arrived, timeout_sec=DEADLINE_S)
        if not arrived.done():
            raise TimeoutError("the arm does not arrive")
    finally:
        watcher.destroy_node()
        ros.try_shutdown()


def _save(picture: Image.Image, file: Path) -> None:
    picture.quantize(256, dither=Image.Dither.FLOYDSTEINBERG).save(file, optimize=True)
    sys.stdout.write(f"{file}: {file.stat().st_size // 1000} kB\n")


PICTURES = {"teleop_arm": draw_arm, "camera": photograph, "sensors": measure}

if __name__ == "__main__":
    for wanted in sys.argv[1:] or PICTURES:
        PICTURES[wanted](FOLDER / f"{wanted}.png")
