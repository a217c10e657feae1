"""``teleopctl launch`` in the foreground: output, crashes, respawning, Ctrl-C, arguments."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from teleopctl.testing import LONGEST_WAIT_S
from tests.samples import sample

STUBBORN = """
import signal, sys, time
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, lambda number, frame: print("ignored", number, flush=True))
print("deaf", flush=True)
while True:
    time.sleep(60)
"""


def write(ros, text, name="file.yaml"):
    (ros.folder / name).write_text(text, encoding="utf-8")


def test_nodes_run_together_with_their_output_prefixed_and_end_on_ctrl_c(ros):
    write(
        ros,
        """launch:
- node: {pkg: teleop_py_pkg, exec: simple_publisher}
- node: {pkg: teleop_py_pkg, exec: simple_subscriber, name: ear, namespace: robot,
         remap: [{from: chatter, to: /chatter}]}
- node: {pkg: teleop_py_pkg, exec: simple_parameter,
         param: [{name: simple_int_param, value: 24}]}
""",
    )
    launch = ros.spawn("launch file.yaml")
    launch.wait_for_line(
        r"^\[INFO\] \[launch\]: All log files can be found below .", stream="stdout"
    )
    launch.wait_for_line(r"^\[INFO\] \[launch\]: Default logging verbosity is set to INFO$")
    pid = int(
        launch.wait_for_line(
            r"^\[INFO\] \[simple_publisher-1\]: process started with pid \[(\d+)\]$"
        )[1]
    )
    launch.wait_for_line(
        r"^\[simple_subscriber-2\] \[INFO\] \[[\d.]+\] \[robot.ear\]: I heard: Hello",
        stream="stdout",
    )
    ros.wait_for_nodes("/simple_parameter")
    got = ros.run("param get /simple_parameter simple_int_param")
    assert got.stdout == "Integer value is: 24\n"
    launch.interrupt()
    launch.wait_for_line(r"^\[WARNING\] \[launch\]: user interrupted with ctrl-c \(SIGINT\)$")
    assert launch.wait() == 0
    for name in ("simple_publisher-1", "simple_subscriber-2", "simple_parameter-3"):
        assert f"[INFO] [{name}]: process has finished cleanly [pid " in launch.stdout
    assert not psutil.pid_exists(pid)
    assert ros.run("node list").stdout == "/test\n"


def test_the_death_of_one_process_leaves_the_others_and_is_told_by_the_exit_status_if_asked(ros):
    write(
        ros,
        """launch:
- executable: {cmd: "sh -c 'exit 3'"}
- executable: {cmd: "sh -c 'read x < fifo; echo still here'", output: screen}
""",
    )
    (ros.folder / "dies.yaml").write_text("launch: [executable: {cmd: sh -c 'exit 3'}]\n")
    os.mkfifo(ros.folder / "fifo")
    launch = ros.spawn("launch file.yaml")
    launch.wait_for_line(
        r"^\[ERROR\] \[sh-1\]: process has died \[pid \d+, exit code 3, cmd 'sh -c exit 3'\]\.$"
    )
    (ros.folder / "fifo").write_text("go\n")
    launch.wait_for_line(r"^\[sh-2\] still here$", stream="stdout")
    launch.wait_for_line(r"^\[INFO\] \[sh-2\]: process has finished cleanly \[pid \d+\]$")
    assert launch.wait() == 0
    assert ros.run("launch --exit-status dies.yaml").returncode == 1


def test_standard_output_of_a_process_is_kept_in_its_log_and_shown_where_asked(ros):
    write(ros, "launch:\n- executable: {cmd: \"sh -c 'echo quiet; echo loud >&2'\"}\n")
    launch = ros.run("launch file.yaml")
    assert launch.returncode == 0
    assert "quiet" not in launch.stdout
    assert "[sh-1] loud\n" in launch.stdout
    log = (ros.folder / "log/latest/sh-1.log").read_text()
    assert sorted(log.splitlines()) == ["loud", "quiet"]
    assert "[sh-1] quiet\n" in ros.run("launch -a file.yaml").stdout


def test_all_output_is_in_a_file_whose_name_can_be_chosen(ros):
    write(ros, "launch:\n- executable: {cmd: echo said, output: log}\n")
    assert ros.run("launch -f everything file.yaml").returncode == 0
    logs = ros.folder / "log/latest"
    assert "[echo-1] said\n" in (logs / "everything.log").read_text()
    assert not (logs / "launch.log").exists()
    refused = ros.run("launch -f some/where file.yaml")
    assert refused.returncode == 2
    assert "--log-file-name is a name, not a path: 'some/where'" in refused.stderr


def test_a_process_that_should_respawn_does_so_as_often_as_allowed(ros):
    write(
        ros,
        """launch:
- executable: {cmd: "sh -c 'echo up'", output: screen, respawn: true, respawn_max_retries: 2}
""",
    )
    launch = ros.run("launch file.yaml")
    assert launch.returncode == 0
    assert launch.stdout.count("process started with pid") == 3
    assert launch.stdout.count("[sh-1] up\n") == 3


@pytest.mark.parametrize("key", ["required: true", "on_exit: shutdown"])
def test_the_end_of_a_required_process_ends_the_launch(ros, key):
    write(
        ros,
        f"launch:\n- executable: {{cmd: 'sleep 100'}}\n- executable: {{cmd: 'true', {key}}}\n",
    )
    launch = ros.run("launch file.yaml")
    assert "process[true-2] was required: shutting down launched system" in launch.stdout
    assert "[INFO] [sleep-1]: process has finished cleanly" in launch.stdout
    assert launch.returncode == 0


def test_a_node_that_is_interrupted_while_python_starts_ends_cleanly(ros):
    os.mkfifo(ros.folder / "fifo")
    (ros.folder / "sitecustomize.py").write_text("open('fifo').read()\n")
    write(
        ros,
        f"""launch:
- node:
    pkg: teleop_py_pkg
    exec: simple_publisher
    env: [{{name: PYTHONPATH, value: '{ros.folder}'}}]
""",
    )
    launch = ros.spawn("launch file.yaml")
    with (ros.folder / "fifo").open("w"):  # it opens when the node's interpreter reads
        launch.interrupt()
        launch.wait_for_line("user interrupted")
    launch.wait_for_line(r"\[INFO\] \[simple_publisher-1\]: process has finished cleanly")
    assert launch.wait() == 0


def test_a_launch_outlives_a_full_disk_behind_its_output(ros):
    write(ros, "launch:\n- executable: {cmd: \"sh -c 'echo one; echo two > done'\"}\n")
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(
            [sys.executable, "-m", "teleopctl", "launch", "file.yaml"],
            env=ros.env,
            cwd=ros.folder,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            timeout=LONGEST_WAIT_S,
        )
    assert (ended.returncode, ended.stderr) == (0, "")
    assert (ros.folder / "done").read_text() == "two\n"


def test_who_does_not_listen_is_terminated_and_then_killed(ros):
    (ros.folder / "stubborn.py").write_text(STUBBORN)
    write(
        ros,
        """launch:
- executable:
    cmd: python3 stubborn.py
    output: screen
    sigterm_timeout: 0.2
    sigkill_timeout: 0.2
- executable: {cmd: sleep 100}
""",
    )
    launch = ros.spawn("launch file.yaml")
    launch.wait_for_line("deaf")
    launch.interrupt()
    launch.wait_for_line(
        r"^\[ERROR\] \[python3-1\]: process\[python3-1\] failed to terminate '0.2' seconds after "
        r"receiving 'SIGINT', escalating to 'SIGTERM'$"
    )
    launch.wait_for_line("escalating to 'SIGKILL'")
    launch.wait_for_line(r"\[python3-1\]: process has died \[pid \d+, exit code -9")
    assert launch.wait() == 0
    assert f"[python3-1] ignored {int(signal.SIGTERM)}\n" in launch.stdout


def test_a_process_that_cannot_be_started_is_reported_and_the_rest_runs(ros):
    write(ros, "launch:\n- executable: {cmd: nosuchprogram}\n- executable: {cmd: echo a}\n")
    launch = ros.run("launch file.yaml")
    assert "[ERROR] [nosuchprogram-1]: process failed to start: No such file" in launch.stdout
    assert "[INFO] [echo-2]: process has finished cleanly" in launch.stdout
    assert launch.returncode == 0


def test_a_delayed_process_starts_later_and_not_at_all_after_ctrl_c(ros):
    write(
        ros,
        """launch:
- executable: {cmd: "sh -c 'echo first; exec sleep 100'", output: screen}
- timer: {period: 0.1, children: [{executable: {cmd: echo second, output: screen}}]}
- timer: {period: 1000, children: [{executable: {cmd: echo never, output: screen}}]}
""",
    )
    launch = ros.spawn("launch --exit-status file.yaml")
    launch.wait_for_line("first")
    launch.wait_for_line("second")
    launch.interrupt()
    assert launch.wait() == 130
    assert "never" not in launch.stdout


def test_arguments_are_passed_and_unknown_ones_warned_about(ros):
    write(
        ros,
        "launch:\n- arg: {name: who, default: world}\n- log: {message: 'hello $(var who)'}\n",
    )
    launch = ros.run("launch file.yaml who:=me whom:=you")
    assert "[INFO] [launch.user]: hello me\n" in launch.stdout
    assert "[WARNING] [launch]: launch argument 'whom' is not declared" in launch.stdout
    assert "(declared: who). Did you mean who?\n" in launch.stdout
    for line, word in (("file.yaml a", "a"), ("my_pkg file.yaml a", "a"), ("who:=me b", "b")):
        wrong = ros.run(f"launch {line}")
        assert wrong.returncode == 2
        assert f"malformed launch argument '{word}'" in wrong.stderr


def test_show_args_and_print_start_nothing(ros):
    write(
        ros,
        """launch:
- arg: {name: who, default: world, description: Whom to greet.}
- arg: {name: how}
- executable: {cmd: "echo $(var who)"}
""",
    )
    shown = ros.run("launch -s file.yaml")
    assert shown.stdout == (
        "Arguments (pass arguments as '<name>:=<value>'):\n"
        "\n    'who':\n        Whom to greet.\n        (default: 'world')\n"
        "\n    'how':\n        no description given\n"
    )
    assert ros.run("launch -p file.yaml how:=x").stdout == "echo-1:\n  echo world\n"
    write(ros, "launch: [executable: {cmd: echo hello, output: screen}]\n", "plain.yaml")
    assert ros.run("launch -s plain.yaml").stdout == (
        "Arguments (pass arguments as '<name>:=<value>'):\n\n  No arguments.\n"
    )
    done = ros.run("launch plain.yaml")
    assert re.fullmatch(
        r"\[INFO\] \[launch\]: All log files can be found below /.+\n"
        r"\[INFO\] \[launch\]: Default logging verbosity is set to INFO\n"
        r"\[INFO\] \[echo-1\]: process started with pid \[(\d+)\]\n"
        r"\[echo-1\] hello\n"
        r"\[INFO\] \[echo-1\]: process has finished cleanly \[pid \1\]\n",
        done.stdout,
    ), done.stdout
    missing = ros.run("launch file.yaml")
    assert missing.returncode == 2
    assert "Required launch argument 'how'" in missing.stderr


@pytest.mark.parametrize(
    ("line", "message", "hint"),
    sample(
        [
            ("launch sym.yaml", "Launch file 'sym.yaml' not found", "sim.yaml"),
            ("launch nope x.yaml", "Package 'nope' not found", ""),
            (
                "launch teleop_description nope.yaml",
                "file 'nope.yaml' was not found in the share directory of package "
                "'teleop_description'",
                "display",
            ),
            ("launch display.yaml model:=nope.xacro", "nope.xacro", ""),
            ("launch -d display.yaml model:=pieces.urdf", "Two root links found: [a] and [b]", ""),
            ("launch -d sim.yaml model:=pieces.urdf", "Two root links found: [a] and [b]", ""),
        ],
        3,
    ),
)
def test_what_does_not_exist_or_does_not_parse_is_named(ros, line, message, hint):
    (ros.folder / "pieces.urdf").write_text(
        '<robot name="x"><link name="a"/><link name="b"/></robot>'
    )
    result = ros.run(line)
    assert (result.stdout, result.returncode) == ("", 1)
    assert message in result.stderr
    assert hint in result.stderr
    assert "Traceback" not in result.stderr


def test_a_launch_file_of_a_package_is_found_in_its_launch_folder(ros):
    folder = ros.folder / "my_pkg"
    (folder / "launch").mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>my_pkg</name></package>")
    (folder / "launch" / "up.yaml").write_text("launch:\n- log: {message: $(dirname)}\n")
    launch = ros.run("launch my_pkg up.yaml")
    assert f"[INFO] [launch.user]: {folder / 'launch'}\n" in launch.stdout


def test_display_shows_any_robot_description(ros):
    (ros.folder / "box.urdf.xacro").write_text(
        '<robot name="box" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:property name="n" value="3"/><link name="base"/><link name="lid_${n}"/>'
        '<joint name="hinge" type="revolute"><parent link="base"/><child link="lid_${n}"/>'
        '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    launch = ros.run("launch -d display.yaml model:=box.urdf.xacro")
    assert launch.returncode == 0, launch.stderr
    echoed = ros.run("topic echo --once /joint_states sensor_msgs/msg/JointState")
    assert "- hinge" in echoed.stdout
    echoed = ros.run("topic echo --once /tf tf2_msgs/msg/TFMessage")
    assert "lid_3" in echoed.stdout


ALL_ACTIVE = [
    "joint_state_broadcaster joint_state_broadcaster/JointStateBroadcaster active",
    "arm_controller joint_trajectory_controller/JointTrajectoryController active",
    "gripper_controller joint_trajectory_controller/JointTrajectoryController active",
]


def controllers(ros):
    listed = ros.run("control list_controllers").stdout
    return [" ".join(line.split()) for line in listed.splitlines()]


def test_sim_brings_up_the_arm_with_active_controllers_and_takes_it_down_again(ros):
    launch = ros.spawn("launch sim.yaml camera:=false")
    launch.wait_for_line(r"\[spawner-\d\]: process has finished cleanly")
    assert controllers(ros) == ALL_ACTIVE
    # The controllers may be active before the simulator has built its model.
    ros.wait_for_nodes("/mujoco_sim", "/controller_manager", "/robot_state_publisher")
    assert "/camera" not in ros.run("node list").stdout.split()
    second = ros.run("launch sim.yaml")
    assert (second.stdout, second.returncode) == ("", 1)
    assert "A simulation runs already\n  End it with `kill -INT " in second.stderr
    undeclared = ros.run("launch sim.yaml nope:=1").stderr.splitlines()
    assert undeclared[0].startswith("WARNING: launch argument 'nope' is not declared")
    assert undeclared[1].startswith("teleopctl: A simulation runs already")
    wrong = ros.run("launch sim.yaml model:=/nope")
    assert "/nope" in wrong.stderr
    assert "A simulation runs already" not in wrong.stderr
    launch.interrupt()
    assert launch.wait() == 0
    assert "escalating" not in launch.stdout
    assert "has died" not in launch.stdout
    assert ros.run("node list").stdout == "/test\n"


PLAIN_ARM = (
    '<robot name="plain"><link name="base"/><link name="tip">'
    '<inertial><mass value="1"/>'
    '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    '<joint name="hinge" type="revolute"><parent link="base"/><child link="tip"/>'
    '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
)


def test_a_description_that_is_refused_ends_the_wait_with_the_reason(ros):
    (ros.folder / "plain.urdf").write_text(PLAIN_ARM)
    result = ros.run("launch -d sim.yaml camera:=false hardware:=as_described model:=plain.urdf")
    assert result.returncode == 1
    # On a slow machine lines before it say what is still starting.
    assert result.stderr.endswith(
        "teleopctl: mujoco_sim-1: the robot description is refused: "
        "no 'ros2_control' tag found in the URDF\n"
        "  The rest of the launch continues; `teleopctl stop sim` ends it.\n"
    )
    assert "mujoco_sim-1 is up" not in result.stdout
    log = ros.run("logs sim").stdout
    assert "Waiting for data on 'robot_description'" not in log.partition("Received robot")[2]
    refused = ros.run("control list_controllers")
    cause = "has not accepted the robot description: no 'ros2_control' tag found in the URDF"
    assert cause in refused.stderr


def test_in_the_foreground_the_spawner_ends_with_the_reason_of_a_refusal(ros):
    (ros.folder / "plain.urdf").write_text(PLAIN_ARM)
    launch = ros.spawn("launch sim.yaml camera:=false hardware:=as_described model:=plain.urdf")
    launch.wait_for_line(
        r"\[spawner-3\].* has not accepted the robot description: no 'ros2_control'"
    )
    launch.wait_for_line(r"\[spawner-3\]: process has died .*exit code 1")
    launch.interrupt()
    launch.wait()


@pytest.mark.nightly
def test_a_controller_that_cannot_be_loaded_fails_the_launch_with_the_managers_reason(ros):
    launch = ros.run("launch -d sim.yaml camera:=false controllers:=nope")
    assert launch.returncode == 1
    # On a slow machine lines before it say what is still starting.
    assert (
        "teleopctl: spawner-3: Failed loading controller nope: "
        "The 'type' param was not defined for 'nope'."
    ) in launch.stderr.splitlines()


def test_a_simulator_that_cannot_build_the_robot_is_not_up(ros):
    # What floats in the middle of a tree: the description is a good one, physics has none of it.
    urdf = PLAIN_ARM.replace(
        "</robot>",
        '<link name="leaf"/><joint name="float" type="floating"><parent link="tip"/>'
        '<child link="leaf"/></joint></robot>',
    )
    (ros.folder / "float.urdf").write_text(urdf)
    result = ros.run("launch -d sim.yaml camera:=false start_controllers:=false model:=float.urdf")
    assert result.returncode == 1
    assert "mujoco_sim-1 is up" not in result.stdout
    assert "float" in result.stderr


def test_a_node_that_waits_for_what_nobody_publishes_is_up(ros):
    started = ros.run("run -d mujoco_sim")
    assert started.returncode == 0, started.stderr
    assert "WARNING" not in started.stderr
    assert started.stdout.startswith("mujoco_sim is up: /mujoco_sim ")


@pytest.mark.nightly
def test_the_simulation_starts_in_a_folder_with_the_sources_of_a_controller_manager(ros):
    folder = ros.folder / "controller_manager"
    folder.mkdir()
    (folder / "package.xml").write_text("<package><name>controller_manager</name></package>")
    (folder / "setup.py").write_text(
        "setup(entry_points={'console_scripts': ['spawner = gone.spawner:main']})"
    )
    started = ros.run("launch -d sim.yaml camera:=false")
    assert started.returncode == 0, started.stderr
    assert "WARNING" not in started.stderr
    assert controllers(ros) == ALL_ACTIVE


@pytest.mark.nightly
def test_the_controllers_can_be_started_on_a_simulation_that_runs(ros):
    started = ros.run("launch -d sim.yaml camera:=false start_controllers:=false")
    assert started.returncode == 0, started.stderr
    assert controllers(ros) == ["No controllers are currently loaded!"]
    started = ros.run("launch -d controller.yaml")
    assert started.returncode == 0, started.stderr
    assert started.stdout == "spawner-1 has finished\ncontroller has finished\n"
    assert controllers(ros) == ALL_ACTIVE
    assert "gazebo_ros2_control" in ros.run("control list_hardware_components").stdout


@pytest.mark.nightly
def test_the_controllers_run_on_mock_hardware_where_there_is_no_simulation(ros):
    started = ros.run("launch -d controller.yaml")
    assert started.returncode == 0, started.stderr
    assert controllers(ros) == ALL_ACTIVE
    assert "mock_components/GenericSystem" in ros.run("control list_hardware_components").stdout


def test_a_description_that_is_a_program_is_refused_with_safe(ros):
    (ros.folder / "robot.xacro").write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">'
        '<link name="${[word for word in [1]]}"/></robot>'
    )
    refused = ros.run("launch --safe display.yaml model:=robot.xacro")
    assert refused.returncode == 1
    assert "robot.xacro:1: refused in safe mode: '[word for word in [1]]'" in refused.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="a script of sh")
@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("file.yaml", "launch:\n- executable: {{cmd: {command}}}\n- log: {{message: {distro}}}"),
        (
            "file.launch.xml",
            '<launch><executable cmd="{command}"/><log message="{distro}"/></launch>',
        ),
    ],
)
def test_commands_of_a_launch_file_see_what_a_sourced_ros_2_gives(ros, name, text):
    (ros.folder / "heard.py").write_text(
        "from std_msgs.msg import String; print(String(data='x').data)"
    )
    (ros.folder / "all.sh").write_text(
        "ros2 interface show std_msgs/msg/Empty --no-comments && echo shown\n"
        "teleopctl interface show std_msgs/msg/Empty && echo again\n"
        f"{sys.executable} heard.py\n"
    )
    write(ros, text.format(command="sh all.sh", distro="$(env ROS_DISTRO)"), name)
    # As where the environment that teleopctl is installed into has not been activated.
    ros.env.update(PATH=os.defpath, ROS_DISTRO="humble")
    got = ros.run(f"launch -a {name}")
    assert got.returncode == 0, got.stderr
    said = re.findall(r"^\[sh-1\] (\w+)$", got.stdout, re.MULTILINE)
    assert said == ["shown", "again", "x"], got.stderr
    assert "[launch.user]: humble" in got.stdout
