"""``tf`` and the programs ``tf2_echo``, ``tf2_monitor``, ``static_transform_publisher``."""

import json
import re
import subprocess
import sys

from teleopctl.testing import LONGEST_WAIT_S

STATIC = "tf2_ros static_transform_publisher"
MOVE_AND_TURN = "--x 1 --y 2 --z 3 --yaw 1.5707963267948966"

PRINTED = """\
At time 0.0
- Translation: [1.000, 2.000, 3.000]
- Rotation: in Quaternion (xyzw) [0.000, 0.000, 0.707, 0.707]
- Rotation: in RPY (radian) [0.000, -0.000, 1.571]
- Rotation: in RPY (degree) [0.000, -0.000, 90.000]
- Matrix:
  0.000 -1.000  0.000  1.000
  1.000  0.000  0.000  2.000
  0.000  0.000  1.000  3.000
  0.000  0.000  0.000  1.000
"""


def publish_static(ros, arguments):
    process = ros.spawn_module("teleopctl.nodes", f"{STATIC} {arguments}")
    process.wait_for_line("Spinning until stopped - publishing transform")
    return process


def test_tf_echo_prints_a_static_transform_once(ros):
    publish_static(ros, f"{MOVE_AND_TURN} --frame-id world --child-frame-id cup")
    done = ros.run("tf echo world cup --once")
    assert (done.returncode, done.stdout) == (0, PRINTED), done.stderr


def test_tf2_echo_ends_when_its_reader_has_enough(ros):
    publish_static(ros, f"{MOVE_AND_TURN} --frame-id world --child-frame-id cup")
    command = [sys.executable, "-m", "teleopctl.nodes", "tf2_ros", "tf2_echo", "world", "cup"]
    with subprocess.Popen(
        command, env=ros.env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as echo:
        assert echo.stdout is not None and echo.stderr is not None
        assert echo.stdout.readline() == "At time 0.0\n"
        echo.stdout.close()
        assert (echo.wait(LONGEST_WAIT_S), echo.stderr.read()) == (0, "")


def test_tf_echo_prints_json(ros):
    publish_static(ros, f"{MOVE_AND_TURN} --frame-id world --child-frame-id cup")
    document = json.loads(ros.run("tf echo world cup --once --json").stdout)
    assert document["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "world"}
    assert document["child_frame_id"] == "cup"
    assert document["transform"]["translation"] == {"x": 1.0, "y": 2.0, "z": 3.0}


def test_tf_echo_waits_for_a_transform_and_ends_quietly_on_ctrl_c(ros):
    echo = ros.spawn("tf echo world cup 20")
    echo.wait_for_line(
        'Waiting for transform world ->  cup: Invalid frame ID "world" passed to canTransform '
        "argument target_frame - frame does not exist",
        stream="stderr",
    )
    publish_static(ros, "--frame-id world --child-frame-id cup")
    echo.wait_for_line("At time 0.0", stream="stdout")
    echo.wait_for_line("At time 0.0", stream="stdout")
    echo.interrupt()
    assert echo.wait() == 0
    assert "Traceback" not in echo.stderr


def test_tf_echo_follows_the_chain_backwards_and_across_publishers(ros):
    publish_static(ros, "--x 1 --frame-id world --child-frame-id table")
    publish_static(ros, "0 0 2 0 0 0 table cup")
    done = ros.run("tf echo cup world --once")
    assert "- Translation: [-1.000, 0.000, -2.000]" in done.stdout


def test_the_node_tf2_echo_prints_the_same_and_logs_while_it_waits(ros):
    echo = ros.spawn("run tf2_ros tf2_echo world cup 20")
    echo.wait_for_line(r"\[INFO\] \[\d+\.\d+\] \[tf2_echo\]: Waiting for transform world ->  cup")
    publish_static(ros, f"{MOVE_AND_TURN} --frame-id world --child-frame-id cup")
    echo.wait_for_line(" 0.000  0.000  0.000  1.000", stream="stdout")
    echo.interrupt()
    assert echo.wait() == 0
    assert echo.stdout.startswith(PRINTED)


def test_what_cannot_be_looked_up_is_told_with_the_frames_that_there_are(ros):
    moving = "{transforms: [{header: {stamp: {sec: 9}, frame_id: world}, child_frame_id: cup}]}"
    words = ["topic", "pub", "-r", "50", "-w", "0", "/tf", "tf2_msgs/msg/TFMessage", moving]
    ros.spawn(words).wait_for_line("publishing #1")
    echo = ros.spawn("run tf2_ros tf2_echo world cup -t 5")
    echo.wait_for_line("Frame cup exists with parent world.", stream="stdout")
    echo.interrupt()
    assert echo.wait() == 0
    reason = "Lookup would require extrapolation (into the past|at time).*"
    assert re.match(
        rf"Failure at \d+\.\d{{3}}\nException thrown:{reason}, when looking up transform from "
        r"frame \[cup\] to frame \[world\]\nThe current list of frames is:\n"
        r"Frame cup exists with parent world\.\n\n",
        echo.stdout,
    )


def test_old_arguments_of_static_transform_publisher_still_work(ros):
    process = publish_static(ros, "1 2 3 1.5707963267948966 0 0 world cup")
    process.wait_for_line("Old-style arguments are deprecated; see --help for new-style arguments")
    assert ros.run("tf echo world cup --once").stdout == PRINTED
    said = re.sub(
        r"\[[\d.]+\] \[static_transform_publisher_[^]]+\]", "[WHEN] [WHO]", process.stderr
    )
    assert said == (
        "[INFO] [WHEN] [WHO]: Spinning until stopped - publishing transform\n"
        "translation: ('1.000000', '2.000000', '3.000000')\n"
        "rotation: ('0.000000', '0.000000', '0.707107', '0.707107')\n"
        "from 'world' to 'cup'\n"
        "[WARN] [WHEN] [WHO]: Old-style arguments are deprecated; see --help for new-style "
        "arguments\n"
    )


def test_wrong_command_lines_end_with_status_2_and_one_message(ros):
    for arguments, message in (
        ("--frame-id world", "required: --child-frame-id"),
        ("--frame-id a --child-frame-id a", "cannot publish static transform from 'a' to 'a'"),
        ("--qx 1 --roll 1 --frame-id a --child-frame-id b", "--roll --pitch --yaw"),
        ("--qw 0 --frame-id a --child-frame-id b", "the quaternion is zero"),
        ("1 2 three 0 0 0 a b", "could not convert string to float: 'three'"),
    ):
        done = ros.run_module("teleopctl.nodes", f"{STATIC} {arguments}")
        assert done.returncode == 2, arguments
        assert message in done.stderr
        assert "Traceback" not in done.stderr
    for arguments in (
        "tf echo world cup 0",
        "run tf2_ros tf2_echo world",
        "run tf2_ros tf2_echo a b x",
        "run tf2_ros tf2_monitor a",
        "tf echo a b -p 18",
        "tf monitor a",
    ):
        done = ros.run(arguments)
        assert (done.returncode, done.stdout) == (2, ""), arguments
        assert "Traceback" not in done.stderr


def test_frames_that_stand_still_and_that_move_are_listed_and_monitored(ros):
    static = ros.spawn("tf static --x 1 --y -2 --frame-id world --child-frame-id table")
    static.wait_for_line("from 'world' to 'table'")
    moving = "{transforms: [{header: {stamp: now, frame_id: table}, child_frame_id: cup}]}"
    ros.spawn(["topic", "pub", "-r", "50", "-n", "mover", "/tf", "tf2_msgs/msg/TFMessage", moving])
    program = ros.spawn("run tf2_ros tf2_monitor world cup -t 0.3")
    program.wait_for_line("Gathering data on world -> cup for 0.3 seconds...", stream="stdout")
    program.wait_for_line("RESULTS: for world to cup", stream="stdout")
    program.wait_for_line("Chain is: world -> table -> cup", stream="stdout")
    program.wait_for_line(r"Net delay {5}avg = [\d.e-]+: max = [\d.e-]+$", stream="stdout")
    number = r"[\d.e+-]+"
    delays = f"Average Delay: {number}, Max Delay: {number}$"
    program.wait_for_line(f"Frame: cup, published by /mover, {delays}", stream="stdout")
    publisher = "/static_transform_publisher_[0-9a-f]+"
    program.wait_for_line(f"Frame: table, published by {publisher}, static", stream="stdout")
    program.wait_for_line(
        f"Node: /mover {number} Hz, Average Delay: {number} Max Delay: {number}$", stream="stdout"
    )
    program.interrupt()
    assert program.wait() == 0
    assert ros.run("tf list -p -t 0.5").stdout == "cup [table]\ntable [world]\nworld\n"
    results = json.loads(ros.run("tf monitor --once -t 0.3 --json").stdout)
    assert [frame["name"] for frame in results["frames"]] == ["cup", "table"]
    rates = {each["node"]: each["rate_hz"] for each in results["broadcasters"]}
    assert rates["/mover"] > 0
    assert None in rates.values()


def test_a_program_that_imports_tf2_ros_runs_unchanged(ros):
    (ros.folder / "looker.py").write_text(
        "import rclpy\n"
        "from rclpy.duration import Duration\n"
        "from rclpy.time import Time\n"
        "from geometry_msgs.msg import TransformStamped\n"
        "from tf2_ros import Buffer, StaticTransformBroadcaster, TransformException\n"
        "from tf2_ros import TransformListener\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('looker')\n"
        "message = TransformStamped()\n"
        "message.header.frame_id, message.child_frame_id = 'world', 'cup'\n"
        "message.transform.translation.x = 4.0\n"
        "StaticTransformBroadcaster(node).sendTransform(message)\n"
        "buffer = Buffer()\n"
        "listener = TransformListener(buffer, node)\n"
        "try:\n"
        "    buffer.lookup_transform('world', 'nowhere', Time())\n"
        "except TransformException as error:\n"
        "    print('refused:', error)\n"
        "found = buffer.lookup_transform('world', 'cup', Time(), Duration(seconds=20))\n"
        "print('x =', found.transform.translation.x)\n"
    )
    done = ros.run("run ./looker.py")
    assert done.returncode == 0, done.stderr
    assert "refused:" in done.stdout
    assert "x = 4.0" in done.stdout
