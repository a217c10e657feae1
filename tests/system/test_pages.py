"""The commands of the documentation's pages work in their order, and write what the pages show."""

import sys

import pytest

from tests import ROOT
from tests.test_docs import TYPED, command_lines, text_of

if sys.platform == "win32":
    pytest.skip("the pages are typed into a shell of POSIX", allow_module_level=True)
from tests.system.page_bags import write_page_bags
from tests.system.reader import Reader, missing, steps

LEROBOT = "--{0}.discover_packages_path=teleopctl.lerobot --{0}.type=teleopctl"
# What no test types; the pages say why, in a comment.
NOT_TYPED = {
    "README": ["pip install '.[test]' && pytest"],
    "launch_files": ["teleopctl launch --watch robots/counting.launch.py"],
    "nodes": ["mypy --strict my_node.py", "teleopctl launch -d sim.yaml"],
    "foxglove": ["teleopctl run foxglove_bridge foxglove_bridge --ros-args -p address:=0.0.0.0"],
    "kinematics": [
        "teleopctl launch pick_and_place.yaml camera:=false times:=20 seed:=1 real_time_factor:=0 "
        "record:=picks",
        "teleopctl bag verify picks",
    ],
    "episodes": [
        f"lerobot-teleoperate {LEROBOT.format('robot')}     {LEROBOT.format('teleop')} "
        '--teleop.topics="[/leader/joint_states]"',
        f"lerobot-record {LEROBOT.format('robot')}     {LEROBOT.format('teleop')}     "
        "--dataset.repo_id=me/wave --dataset.single_task=wave --dataset.push_to_hub=false",
        f"lerobot-replay {LEROBOT.format('robot')}     "
        "--dataset.repo_id=me/wave --dataset.episode=0",
        "lerobot-train --dataset.repo_id=me/cube --dataset.root=cube --policy.type=act     "
        "--policy.push_to_hub=false --output_dir=act --steps=100000",
        "teleopctl launch sim.yaml -d world:=package://teleopctl/worlds/pick_and_place.yaml "
        "camera_width:=640 camera_height:=360",
        f"lerobot-rollout {LEROBOT.format('robot')}     "
        '--policy.path=act/checkpoints/last/pretrained_model --task="Put the cube into the bin" '
        "--duration=20",
        "teleopctl stop sim",
    ],
    "page": [
        "teleopctl view                          # the running robot: "
        "teleopctl run rviz2 rviz2 --open",
        "teleopctl view session                  # a bag; --over other_session lays a second one "
        "over it",
        "teleopctl view my_robot.urdf.xacro      # a robot's file, with sliders: "
        "launch display.yaml",
        "teleopctl view my_robot.rviz            # an .rviz file; my_layout.yaml a layout",
        "teleopctl run rviz2 rviz2 --host 0.0.0.0",
    ],
    "ros2": [
        "export RMW_IMPLEMENTATION=rmw_zenoh_cpp",
        "ros2 daemon stop     # a daemon that runs on another middleware would answer for it",
        "ros2 topic list",
        "export ZENOH_CONFIG_OVERRIDE='listen/endpoints=[\"tcp/[::]:7447\"]'",
        "teleopctl daemon start",
        "unset ZENOH_CONFIG_OVERRIDE",
        "export TELEOPCTL_ROUTER=tcp/192.0.2.2:7447",
        "teleopctl daemon status",
        "teleopctl topic echo --once /chatter",
        'export ZENOH_CONFIG_OVERRIDE=\'mode="client";connect/endpoints=["tcp/192.0.2.2:7447"]\'',
    ],
    "simulation": ["teleopctl logs camera-3", "teleopctl topic hz /image_raw"],
}

# Typed in each run. The others start robots by the dozen, a run of each page takes many seconds;
# what their commands do has tests of its own.
SHORT = ("README",)
PAGES = [pytest.param(name, marks=() if name in SHORT else pytest.mark.nightly) for name in TYPED]

# What its reader has already.
OWN_FILES = {
    "from_ros2": {
        "bringup.launch.py": (
            "from launch import LaunchDescription\n"
            "from launch_ros.actions import Node\n"
            "def generate_launch_description():\n"
            "    publisher = dict(package='robot_state_publisher')\n"
            "    return LaunchDescription([\n"
            "        Node(package='nav2_bringup', executable='x'),\n"
            "        Node(executable='robot_state_publisher', **publisher)])\n"
        )
    },
    "nodes": {
        "ws/src/ros2_control/controller_manager/package.xml": (
            "<package><name>controller_manager</name><version>1.0.0</version></package>"
        ),
        "ws/src/ros2_control/controller_manager/CMakeLists.txt": "add_library(x SHARED x.cpp)\n",
        "ws/src/joint_state_publisher/package.xml": (
            "<package><name>joint_state_publisher</name><version>1.0.0</version></package>"
        ),
    },
    "page": {
        "my_robot.rviz": "Visualization Manager: {Displays: [{Class: rviz_default_plugins/TF}]}",
    },
}


@pytest.fixture
def reader(ros_without_router):
    """A reader in the checkout's folder, on whose machine nothing runs yet."""
    ros = ros_without_router
    (ros.folder / "robot").symlink_to(ROOT / "robot")
    ros.env["TELEOPCTL_ROUTER"] = f"tcp/localhost:{ros.port}"
    return Reader(ros)


@pytest.mark.timeout(600)
@pytest.mark.parametrize("name", PAGES)
def test_the_commands_of_a_page_work_in_their_order(reader, name):
    if name == "page":
        reader.ros.env["TELEOPCTL_VIEWER"] = "true"
    if name == "bag":
        write_page_bags(reader.ros.folder)
        reader.ros.env["BROWSER"] = "true"  # the program, which opens nothing
    for file, text in OWN_FILES.get(name, {}).items():
        reader.write(file, text)
    reader.follow(text_of(TYPED[name]), tables=name == "cheat_sheet")


def test_every_command_of_a_page_is_typed_unless_it_is_listed_here():
    for name, page in TYPED.items():
        commands = [step for step in steps(text_of(page)) if step.line]
        assert sorted(step.line for step in commands) == sorted(command_lines(page))
        left_out = [step.line for step in commands if not step.is_typed]
        assert left_out == NOT_TYPED.get(name, [])


def test_the_numbers_of_a_block_that_is_marked_have_to_be_right():
    shown = ("[INFO] [1795251226.173626512] position 1.75", "At time 15.3", "- -1.115 nan")
    assert missing(shown, "\n".join(shown), numbers=True) == []
    again = "[INFO] [1795251299.173626512] position 1.7501\nAt time 17.3\n- -1.115 nan\n"
    assert missing(shown, again, numbers=True) == []
    assert missing(shown, again.replace("1.7501", "1.71"), numbers=True)
    assert missing(shown, again.replace("- -", "- "), numbers=True)


@pytest.mark.parametrize(
    ("shown", "output", "is_there"),
    [
        ("average rate: 10.000", "average rate: 9.987", True),
        ("average rate: 10.000", "average delay: 10.000", False),
        ("talker is up: /anna [pid 6439]", "talker is up: /anna [pid 12]", True),
        ("talker is up: /anna [pid 6439]", "talker is up: /bert [pid 12]", False),
        ("joint_1: 0.5", "joint_2: 0.5", False),
        ("/home/me/ws/a.yaml:3: no", "/tmp/x/a.yaml:17: no", True),
        ("router  5217  router  1m14s  …", "router 9 router 2s python -m x", True),
        ("^C[INFO] done", "[INFO] done", True),
        ("GID: " + ".".join(["d5"] * 16), "GID: " + ".".join(["0a"] * 16), True),
    ],
)
def test_what_a_page_shows_has_to_come_but_for_numbers_times_and_paths(shown, output, is_there):
    assert missing((shown,), f"before\n{output}\nafter") == (
        [] if is_there else [shown.strip("^C")]
    )
