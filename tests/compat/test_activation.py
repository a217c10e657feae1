"""The ways to a process in which ``rclpy`` can be imported, each with real processes."""

import os
import sys

import pytest

from tests.compat.activated import output
from tests.samples import sample

SEES_RCLPY = "import rclpy, std_msgs.msg; print(std_msgs.msg.String(data='seen'))"
SEEN = "std_msgs.msg.String(data='seen')\n"

NODE = """
import sys
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


def main():
    rclpy.init()
    node = Node("plain")
    try:
        print(node.get_fully_qualified_name(), rclpy.utilities.remove_ros_args()[1:], flush=True)
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        print("leaving", flush=True)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
"""


def test_activation_is_idempotent_and_comes_behind_all_that_is_there():
    code = """
import sys
from teleopctl.compat import activation
before = list(sys.path), list(sys.meta_path)
teleopctl.activate()
print(before == (sys.path, sys.meta_path), sys.path[-1] == activation.SITE)
"""
    assert output(code) == "True True"


def test_children_are_told_once_and_keep_their_own_path(tmp_path):
    code = """
import os
from teleopctl.compat import activation
for _ in range(2):
    activation.activate_children()
print(os.environ["PYTHONPATH"] == activation.START_HOOK + os.pathsep + os.environ["MINE"])
"""
    assert output(code, tmp_path, MINE=str(tmp_path)) == "True"


@pytest.mark.parametrize(
    "args",
    [
        ["-c", SEES_RCLPY],
        ["-m", "sees"],
        ["sees.py"],
        ["-c", f"import subprocess, sys; subprocess.run([sys.executable, '-c', {SEES_RCLPY!r}])"],
        ["spawns.py"],
    ],
    ids=["code", "module", "script", "child", "spawned"],
)
def test_python_sees_rclpy_however_it_is_started(shared_ros, args):
    (shared_ros.folder / "sees.py").write_text(SEES_RCLPY)
    (shared_ros.folder / "spawns.py").write_text(
        "import multiprocessing\n\n"
        f"def see():\n    {SEES_RCLPY}\n\n"
        'if __name__ == "__main__":\n'
        '    process = multiprocessing.get_context("spawn").Process(target=see)\n'
        "    process.start()\n"
        "    process.join()\n"
    )
    done = shared_ros.run(["python", *args])
    assert (done.returncode, done.stdout) == (0, SEEN), done.stderr


def test_the_prompt_reads_from_standard_input(shared_ros):
    done = shared_ros.run(["python"], input=SEES_RCLPY)
    assert (done.returncode, done.stdout) == (0, SEEN), done.stderr


def test_arguments_and_exit_status_are_pythons_own(shared_ros):
    words = ["--help", "-x", "--", "--no-daemon", ""]
    done = shared_ros.run(["python", "-c", "import sys; print(sys.argv); sys.exit(7)", *words])
    assert (done.returncode, done.stdout) == (7, f"{['-c', *words]}\n")
    assert shared_ros.run(["python", "--version"]).stdout == f"Python {sys.version.split()[0]}\n"
    failed = shared_ros.run(["python", "none.py"])
    assert failed.returncode == 2
    assert "can't open file" in failed.stderr


def test_its_help_is_teleopctls(shared_ros):
    done = shared_ros.run(["python", "--help"])
    assert done.returncode == 0
    assert "Usage: teleopctl python [OPTIONS] [ARGS]..." in done.stdout


def test_pytest_runs_in_it_without_the_plug_in(shared_ros):
    (shared_ros.folder / "test_node.py").write_text(f"{SEES_RCLPY}\ndef test_it(): pass\n")
    done = shared_ros.run(
        ["python", "-m", "pytest", "-p", "no:teleopctl", "-p", "no:cacheprovider", "test_node.py"]
    )
    assert done.returncode == 0, done.stdout


@pytest.mark.skipif(os.name == "nt", reason="Windows has neither of these signals to send")
@pytest.mark.parametrize("way", sample(["python", "run"], 2))
@pytest.mark.parametrize("end", ["interrupt", "terminate"])
def test_an_unchanged_node_is_the_same_in_both(shared_ros, way, end):
    (shared_ros.folder / "plain.py").write_text(NODE)
    args = [way, "./plain.py", "one", "--ros-args", "-r", "__ns:=/space", "-r", "__node:=named"]
    process = shared_ros.spawn(args)
    process.wait_for_line(r"^/space/named \['one'\]$")
    getattr(process, end)()
    process.wait_for_line("^leaving$")
    assert process.wait() == 0
    assert "Traceback" not in process.stderr


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGINT to die of")
def test_ctrl_c_that_nobody_catches_ends_as_in_python(shared_ros):
    code = "import threading; print('up', flush=True); threading.Event().wait()"
    process = shared_ros.spawn(["python", "-c", code])
    process.wait_for_line("up")
    process.interrupt()
    assert process.wait() == -2
    assert "KeyboardInterrupt" in process.stderr


def test_what_a_program_under_run_starts_sees_rclpy_too(shared_ros):
    (shared_ros.folder / "starts.py").write_text(
        f"import subprocess, sys\nsubprocess.run([sys.executable, '-c', {SEES_RCLPY!r}])\n"
    )
    done = shared_ros.run(["run", "./starts.py"])
    assert (done.returncode, done.stdout) == (0, SEEN), done.stderr


def test_what_is_really_installed_wins_in_python(shared_ros, tmp_path, monkeypatch):
    (tmp_path / "rclpy.py").write_text("print('the real one')\n")
    monkeypatch.setitem(shared_ros.env, "PYTHONPATH", str(tmp_path))
    assert shared_ros.run(["python", "-c", "import rclpy"]).stdout == "the real one\n"


def test_the_users_own_sitecustomize_still_runs(shared_ros, tmp_path, monkeypatch):
    (tmp_path / "sitecustomize.py").write_text("print('mine')\nMARK = 1\n")
    monkeypatch.setitem(shared_ros.env, "PYTHONPATH", str(tmp_path))
    done = shared_ros.run(
        ["python", "-c", f"import sitecustomize as s; print(s.MARK); {SEES_RCLPY}"]
    )
    assert done.stdout == f"mine\nmine\n1\n{SEEN}"


def test_a_broken_sitecustomize_is_reported_by_python_and_changes_nothing(
    shared_ros, tmp_path, monkeypatch
):
    (tmp_path / "sitecustomize.py").write_text("import no_such_module\n")
    monkeypatch.setitem(shared_ros.env, "PYTHONPATH", str(tmp_path))
    done = shared_ros.run(["python", "-c", SEES_RCLPY])
    assert (done.returncode, done.stdout) == (0, SEEN), done.stderr
    assert "no_such_module" in done.stderr


def test_a_python_without_teleopctl_is_left_as_it_is(shared_ros):
    # -S leaves out site-packages, and teleopctl with them; what Python would run is run by hand.
    code = "import sitecustomize, sys; print([p for p in sys.path if 'start_hook' in p])"
    done = shared_ros.run(["python", "-S", "-c", code])
    assert (done.returncode, done.stdout) == (0, "[]\n"), done.stderr


def test_start_up_loads_little_that_a_plain_python_would_not(shared_ros):
    code = "import sys; print(*sys.modules)"
    plain = shared_ros.spawn_command([sys.executable, "-c", code])
    assert plain.wait() == 0
    activated = shared_ros.run(["python", "-c", code])
    more = set(activated.stdout.split()) - set(plain.stdout.split())
    others = {name for name in more if not name.startswith("teleopctl")}
    light = {"__future__", "importlib", "importlib._bootstrap", "importlib._bootstrap_external"}
    light |= {"importlib.machinery", "sitecustomize", "types", "warnings", "operator", "_operator"}
    light |= {"_functools"}
    assert others <= light


def test_programs_find_ros2_and_xacro_behind_what_is_installed(tmp_path):
    arm = tmp_path / "arm.xacro"
    arm.write_text('<robot name="arm"><link name="base"/></robot>')
    code = f"""
import os, shutil, subprocess
from teleopctl.compat import activation
# pip's xacro, or a sourced ROS 2, has programs of these names too, which come first.
places = os.environ["PATH"].split(os.pathsep)
os.environ["PATH"] = os.pathsep.join(
    place for place in places
    if not any(shutil.which(name, path=place) for name in ("ros2", "xacro"))
)
for _ in range(2):
    activation.activate_children()
assert os.environ["PATH"].count(activation.PROGRAMS) == 1
for words in (["ros2", "interface", "show", "std_msgs/msg/String"], ["xacro", {str(arm)!r}]):
    program = shutil.which(words[0])
    print(program.startswith(activation.PROGRAMS))
    print(subprocess.run([program, *words[1:]], capture_output=True, text=True).stdout.split())
mine = shutil.copy(shutil.which("ros2"), {str(tmp_path)!r})
os.environ["PATH"] = {str(tmp_path)!r} + os.pathsep + os.environ["PATH"]
print(shutil.which("ros2") == mine)
print(os.environ["ROS_VERSION"], os.environ["ROS_DISTRO"])
# Launch files append to these without asking whether they are set.
paths = ("LD_LIBRARY_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH")
print(all(name in os.environ for name in paths))
"""
    *shown, variables, has_paths = output(code, ROS_DISTRO="humble").splitlines()
    assert (variables, has_paths) == ("2 humble", "True")
    first, definition, second, robot, third = shown
    assert (first, second, third) == ("True", "True", "True")
    assert definition == "['string', 'data']"
    assert 'name="base"' in robot.replace("\\", "")
