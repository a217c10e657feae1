"""``teleopctl run``: the tutorial's nodes, users' packages and plain files, in real processes."""

import os
import shlex
import signal
import sys

import pytest

from teleopctl.interfaces import get_message
from teleopctl.node import qos_profile_latched
from teleopctl.packages import package_share
from teleopctl.testing import eventually

ARM = "urdf/teleop.urdf.xacro"

TALKER = """
import sys

import rclpy
from rclpy.node import Node
from std_msgs.msg import String


class Talker(Node):
    def __init__(self):
        super().__init__("my_talker")
        self.publisher = self.create_publisher(String, "chatter", 10)
        self.create_timer(0.05, self.say)

    def say(self):
        self.publisher.publish(String(data="from a plain file"))


def main(args=None):
    rclpy.init(args=args)
    node = Talker()
    print("arguments", sys.argv[1:], flush=True)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
"""


def test_the_tutorials_publisher_and_subscriber_talk(ros):
    publisher = ros.spawn("run teleop_py_pkg simple_publisher")
    publisher.wait_for_line(r"^\[INFO\] \[\d+\.\d+\] \[simple_publisher\]: Publishing at 1.0 Hz")
    subscriber = ros.spawn("run teleop_py_pkg simple_subscriber")
    subscriber.wait_for_line(
        r"^\[INFO\] \[\d+\.\d+\] \[simple_subscriber\]: I heard: Hello ROS 2 - counter: \d+$"
    )
    for process in (publisher, subscriber):
        process.interrupt()
        assert process.wait() == 0
        assert "Traceback" not in process.stderr


def test_a_description_given_as_the_tutorial_gives_it_is_published(ros):
    expanded = ros.run(["run", "xacro", "xacro", str(package_share("teleop_description") / ARM)])
    assert expanded.returncode == 0, expanded.stderr
    description = expanded.stdout.rstrip("\n")  # as $(…) hands it over
    assert description.startswith("<?xml")
    assert "$(find" not in description
    node = ros.spawn(
        [
            *("run", "robot_state_publisher", "robot_state_publisher"),
            *("--ros-args", "-p", f"robot_description:={description}"),
        ]
    )
    node.wait_for_line("got segment claw_support")
    published = ros.wait_for_message(
        get_message("std_msgs/msg/String"), "/robot_description", qos=qos_profile_latched
    )
    assert published.data == description


def test_xacro_finds_our_packages_and_says_what_it_does_not_find(ros, tmp_path):
    file = tmp_path / "a.xacro"
    share = ros.run("pkg prefix --share teleop_description").stdout.strip()
    for package, status in (("teleop_description", 0), ("nowhere", 2)):
        file.write_text(
            '<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">'
            f'<link name="$(find {package})"/></robot>'
        )
        done = ros.run(["run", "xacro", "xacro", str(file)])
        assert done.returncode == status, done.stderr
        assert (f'<link name="{share}"/>' in done.stdout) == (status == 0)
        assert ("nowhere" in done.stderr) == (status != 0)


def test_the_tutorials_parameter_node_takes_overrides_and_reports_changes(ros):
    node = ros.spawn("run teleop_robot_py_pkg simple_parameter --ros-args -p simple_int_param:=24")
    ros.wait_for_nodes("/simple_parameter")
    got = ros.run("param get /simple_parameter simple_int_param")
    assert got.stdout == "Integer value is: 24\n"
    got = ros.run("param get /simple_parameter simple_string_param")
    assert got.stdout == "String value is: Antonio\n"
    assert ros.run("param set /simple_parameter simple_int_param 30").returncode == 0
    node.wait_for_line("Param simple_int_param changed! New value is 30")
    refused = ros.run("param set /simple_parameter simple_int_param text")
    assert refused.returncode == 1
    assert "Setting parameter failed" in refused.stderr


def test_a_plain_file_runs_unchanged_and_gets_its_arguments_untouched(ros):
    (ros.folder / "talker.py").write_text(TALKER)
    subscriber = ros.spawn("run simple_subscriber")
    talker = ros.spawn("run ./talker.py --help -d --ros-args -r __node:=other -- x")
    talker.wait_for_line(
        r"arguments \['--help', '-d', '--ros-args', '-r', '__node:=other', '--', 'x'\]"
    )
    subscriber.wait_for_line("I heard: from a plain file")
    assert "/other" in ros.run("node list").stdout.splitlines()
    talker.interrupt()
    assert talker.wait() == 130
    assert "Traceback" not in talker.stderr


@pytest.mark.skipif(os.name == "nt", reason="shells of Windows do not do that")
@pytest.mark.parametrize(
    "line", ["topic echo /unheard std_msgs/msg/String", "run teleop_py_pkg simple_publisher"]
)
def test_a_script_can_interrupt_what_it_put_into_the_background(ros, line):
    # Without job control a shell starts background commands with SIGINT ignored.
    script = (
        f"""{shlex.quote(sys.executable)} -m teleopctl {line} & echo $!; wait $!; echo status $?"""
    )
    shell = ros.spawn_command(["sh", "-c", script])
    pid = int(shell.wait_for_line(r"^\d+$")[0])
    eventually(lambda: ros.run("node list -a").stdout != "")
    os.kill(pid, signal.SIGINT)
    shell.wait_for_line("^status (0|130)$")


def test_sigterm_shuts_a_node_down_without_noise(ros):
    (ros.folder / "talker.py").write_text(TALKER)
    talker = ros.spawn("run ./talker.py")
    talker.wait_for_line("arguments")
    talker.terminate()
    assert talker.wait() == 0
    assert "Traceback" not in talker.stderr


def test_a_source_package_runs_without_being_built(ros):
    package = ros.folder / "src" / "my_pkg"
    (package / "my_pkg").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>my_pkg</name></package>")
    (package / "setup.py").write_text(
        "from setuptools import setup\n"
        "setup(entry_points={'console_scripts': ['talk = my_pkg.talk:main']})\n"
    )
    (package / "my_pkg" / "__init__.py").touch()
    (package / "my_pkg" / "words.py").write_text("WORD = 'imported from beside'\n")
    (package / "my_pkg" / "talk.py").write_text(
        "from my_pkg.words import WORD\ndef main():\n    print(WORD)\n    return 5\n"
    )
    for line in ("run my_pkg talk", "run talk", "run my_pkg"):
        result = ros.run(line)
        assert (result.returncode, result.stdout) == (5, "imported from beside\n"), line


def test_the_end_of_a_program_is_the_end_of_the_command(ros):
    (ros.folder / "exits.py").write_text("import gc, sys\nsys.exit(4 if gc.isenabled() else 5)\n")
    assert ros.run("run ./exits.py").returncode == 4
    (ros.folder / "fails.py").write_text("def f():\n    raise ValueError('mine')\nf()\n")
    failed = ros.run("run ./fails.py")
    assert failed.returncode == 1
    assert "fails.py" in failed.stderr.splitlines()[1]
    assert failed.stderr.endswith("ValueError: mine\n")
    # An exception of ours that it lets through is one of its own, as with rclpy.
    (ros.folder / "names.py").write_text(
        "import rclpy\nfrom std_msgs.msg import String\n\n\ndef main():\n    rclpy.init()\n"
        "    node = rclpy.create_node('mine')\n"
        "    node.create_publisher(String, 'no good', 10)\n\n\nmain()\n"
    )
    failed = ros.run("run ./names.py")
    assert failed.returncode == 1
    assert failed.stderr.startswith("Traceback (most recent call last):\n")
    assert 'names.py", line 8, in main' in failed.stderr
    assert "InvalidTopicNameException: Invalid topic name" in failed.stderr
    assert "teleopctl/node" not in failed.stderr
    (ros.folder / "typo.py").write_text("x = (\n")
    failed = ros.run("run ./typo.py")
    assert failed.returncode == 1
    assert "typo.py" in failed.stderr.splitlines()[0]
    assert "SyntaxError" in failed.stderr.splitlines()[-1]


@pytest.mark.parametrize(
    ("line", "message", "hint"),
    [
        ("run nope x", "Package 'nope' not found", ""),
        (
            "run teleop_py_pgk simple_publisher",
            "Package 'teleop_py_pgk' not found",
            "teleop_py_pkg",
        ),
        ("run teleop_py_pkg simple_publishr", "No executable found", "simple_publisher"),
        ("run ./nope.py", "No executable found", "nope.py"),
    ],
)
def test_what_does_not_exist_is_named(ros, line, message, hint):
    result = ros.run(line)
    assert result.returncode == 1
    assert result.stdout == ""
    assert message in result.stderr
    assert hint in result.stderr
    assert "Traceback" not in result.stderr


def test_the_router_is_started_where_none_answers(ros_without_router):
    ros = ros_without_router
    publisher = ros.spawn("run simple_publisher")
    publisher.wait_for_line("Publishing")
    assert ros.run("daemon status").stdout.startswith("The daemon is running\n")
    publisher.interrupt()
    assert publisher.wait() == 0


def test_a_file_with_the_name_of_a_python_module_is_not_taken_for_it(ros_without_router):
    ros = ros_without_router
    for name in ("copy", "queue", "random", "select"):
        (ros.folder / f"{name}.py").write_text(f"raise SystemExit('took {name}.py')\n")
    line = "-P -m teleopctl run simple_publisher"
    publisher = ros.spawn_command([sys.executable, *line.split()])
    publisher.wait_for_line("Publishing")


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs env, a program of Unix")
def test_a_prefix_stands_before_the_command_line(ros):
    (ros.folder / "show.py").write_text("import os\nprint(os.environ['A_WORD'])\n")
    assert ros.run("run --prefix 'env A_WORD=prefixed' ./show.py").stdout == "prefixed\n"
    missing = ros.run("run --prefix nosuchprogram ./show.py")
    assert missing.returncode == 1
    assert "nosuchprogram" in missing.stderr


@pytest.mark.skipif(os.name == "nt", reason="no file of Windows needs to be marked as a program")
@pytest.mark.parametrize(
    ("name", "mode", "hint"),
    [
        ("arm.urdf", 0o644, "teleopctl launch display.yaml model:="),
        ("arm.urdf.xacro", 0o755, "teleopctl launch display.yaml model:="),
        ("up.yaml", 0o644, "teleopctl launch "),
        ("tool", 0o644, "chmod +x "),
    ],
)
def test_a_file_that_is_no_program_is_told_what_it_is_for(ros, name, mode, hint):
    file = ros.folder / name
    file.write_text("<robot name='arm'/>\n")
    file.chmod(mode)
    done = ros.run(f"run ./{name}")
    assert done.returncode == 1
    assert f"{file} is no program" in done.stderr
    assert f"{hint}{file}" in done.stderr
