"""``launch --watch``: what is saved starts again, and nothing takes that for a crash."""

import textwrap
from pathlib import Path

import pytest

from teleopctl.launch.model.plan import ProcessPlan
from teleopctl.launch.watch import files_read, sources_of

XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
KEPT = r"^\[ERROR\] \[launch\]: {} saved; running processes stay until the next save: "
FILES = {
    "words/package.xml": "<package><name>words</name></package>",
    "words/words/__init__.py": "WORD = 'one'\n",
    "pkg/package.xml": "<package><name>pkg</name><exec_depend>words</exec_depend></package>",
    "pkg/setup.py": "from setuptools import setup\n"
    "setup(name='pkg', entry_points={'console_scripts': ['talker = pkg.talker:main']})\n",
    "pkg/pkg/__init__.py": "",
    "pkg/pkg/talker.py": """
        import rclpy
        from words import WORD

        def main():
            rclpy.init()
            node = rclpy.create_node("talker")
            print(f"says {WORD} {node.declare_parameter('times', 0).value}", flush=True)
            rclpy.spin(node)
        """,
    "talker.yaml": "talker: {ros__parameters: {times: 1}}\n",
    "sizes.xacro": f'<robot {XACRO}><xacro:property name="r" value="0.1"/></robot>\n',
    "arm.xacro": f"""
        <robot name="arm" {XACRO}>
        <xacro:include filename="sizes.xacro"/>
        <link name="a"><visual><geometry><sphere radius="${{r}}"/></geometry></visual></link>
        </robot>
        """,
    "up.launch.py": """
        import os, xacro
        from launch import LaunchDescription
        from launch.actions import LogInfo, RegisterEventHandler, Shutdown
        from launch.event_handlers import OnProcessExit, OnProcessStart
        from launch_ros.actions import Node

        HERE = os.path.dirname(__file__)

        def generate_launch_description():
            robot = xacro.process_file(os.path.join(HERE, "arm.xacro")).toxml()
            talker = Node(
                package="pkg", executable="talker", output="screen", on_exit=Shutdown(),
                parameters=[os.path.join(HERE, "talker.yaml")])
            return LaunchDescription([
                Node(package="robot_state_publisher", executable="robot_state_publisher",
                     parameters=[{"robot_description": robot}]),
                RegisterEventHandler(OnProcessStart(on_start=[LogInfo(msg="a start")])),
                RegisterEventHandler(OnProcessExit(on_exit=[LogInfo(msg="an end")])),
                talker,
            ])
        """,
}


@pytest.fixture
def folder(ros) -> Path:
    for name, text in FILES.items():
        path = ros.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text).lstrip())
    root: Path = ros.folder
    return root


def save(path: Path, text: str) -> None:
    """As editors do: a new file in the place of the old one."""
    new = path.with_suffix(".new")
    new.write_text(text)
    new.replace(path)


def test_what_is_saved_starts_again_and_no_handler_takes_that_for_an_end(ros, folder):
    launch = ros.spawn("launch --watch up.launch.py")
    launch.wait_for_line(r"^\[talker-2\] says one 1$")
    word = folder / "words/words/__init__.py"
    save(word, "WORD = 'another'\n")
    launch.wait_for_line(r"^\[INFO\] \[launch\]: __init__.py saved: talker-2 restarts$")
    launch.wait_for_line(r"^\[talker-2\] says another 1$")

    save(word, "WORD = 'no end\n")
    launch.wait_for_line(KEPT.format("__init__.py") + ".*:1: unterminated")
    save(word, "WORD = unknown\n")
    launch.wait_for_line(r"^\[ERROR\] \[talker-2\]: process has died .* exit code 1")
    launch.wait_for_line(r"^\[INFO\] \[launch\]: talker-2 waits for the next save$")
    (folder / "talker.yaml").write_text("talker: {ros__parameters: {times: 23}}\n")
    save(word, "WORD = 'mended'\n")
    launch.wait_for_line(r"^\[talker-2\] says mended 23$")
    assert "robot_state_publisher-1 restarts" not in launch.stdout

    save(folder / "sizes.xacro", FILES["sizes.xacro"].replace("0.1", "${nothing}"))
    launch.wait_for_line(KEPT.format("sizes.xacro") + ".*'nothing' is not")
    save(folder / "sizes.xacro", FILES["sizes.xacro"].replace("0.1", "0.25"))
    launch.wait_for_line(
        r"^\[INFO\] \[launch\]: sizes.xacro saved: robot_state_publisher-1 restarts"
    )
    launch.wait_for_line(r"^\[INFO\] \[robot_state_publisher-1\]: process started")
    (folder / "arm.xacro").unlink()
    launch.wait_for_line(
        r"^\[WARNING\] \[launch\]: arm.xacro: gone; the processes made from it keep running"
    )

    assert launch.stdout.count("[launch.user]: a start") == 2
    assert "[launch.user]: an end" not in launch.stdout
    launch.interrupt()
    assert launch.wait() == 0
    assert launch.stdout.count("[launch.user]: an end") == 2
    assert "escalating" not in launch.stdout


def test_in_the_background_too_and_a_launch_of_which_all_has_ended_waits_for_a_save(ros):
    (ros.folder / "once.py").write_text("print('first')\n")
    (ros.folder / "file.yaml").write_text("launch: [executable: {cmd: python3 once.py}]\n")
    launched = ros.run("launch -d --watch file.yaml")
    assert launched.returncode == 0, launched.stderr
    log = ros.spawn("logs -f file")
    log.wait_for_line("all processes have ended; saved ones start again, Ctrl-C ends the launch")
    save(ros.folder / "once.py", "print('second')\n")
    log.wait_for_line(r"once.py saved: python3-1 restarts")
    log.wait_for_line(r"^\[python3-1\] second$")
    assert ros.run("stop file").returncode == 0


def test_a_process_is_made_from_its_package_those_it_depends_on_and_files_that_it_is_given(
    folder, monkeypatch
):
    monkeypatch.chdir(folder)
    node = ["python", "-P", "-m", "teleopctl.nodes", "pkg", "talker", "--ros-args"]
    plan = ProcessPlan(name="talker-1", command=[*node, "--params-file", "talker.yaml"])
    below = {"pkg/pkg/__init__.py", "pkg/pkg/talker.py", "words/words/__init__.py", "talker.yaml"}
    assert sources_of(plan, folder / "log") == {folder / name for name in below}
    (folder / "table.csv").write_text("what it writes")
    shell = ProcessPlan(name="sh-1", command=["python3 up.launch.py table.csv"], shell=True)
    assert sources_of(shell, folder / "log") == {folder / "up.launch.py"}
    assert sources_of(shell, folder) == frozenset()
    ours = ProcessPlan(name="x-1", command=[*node[:4], "rviz2", "rviz2"])
    assert sources_of(ours, folder / "log") == frozenset()


def test_the_files_that_are_read_are_known_but_for_those_that_are_written_as_well(tmp_path):
    read, both = tmp_path / "read", tmp_path / "both"
    read.write_text("")
    with files_read() as found:
        both.write_text(read.read_text())
        both.read_text()
        Path(__file__).with_name("gone").exists()
    assert found == {read}
