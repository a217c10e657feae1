"""mypy --strict, as its users run it, on a node that uses rclpy and messages."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

# mypy reads the libraries for ten seconds.
pytestmark = pytest.mark.nightly

NODE = Path(__file__).with_name("talker.py")

# Each line is added to the node's `values` and is wrong.
WRONG = (
    "Talker().publisher.publish(42)",
    "Talker().publisher.publish(Header())",
    "String(dada='x')",
    "String(data=42)",
    "String().dada = 'x'",
    "String().data = 42",
    "state.name = 'a string is a sequence of strings too'",
    "state.position = ['1.0']",
    "state.header.stamp.sec = 1.5",
    "state.header = state",
    "BatteryState.POWER_SUPPLY_STATUS_FULL = 7",
    "Talker().create_publisher(AddTwoInts, 'x', 10)",
    "Talker().create_publisher('std_msgs/msg/String', 'x', 10)",
    "Talker().create_subscription(String, 'x', Talker().hear, 10)",
    "Talker().create_subscription(String, 'x', Talker().take, 10)",
    "Talker().create_subscription(String, 'x', Talker().hear, 10, raw=True)",
    "Talker().create_service(AddTwoInts, 'x', Talker().hear)",
    "Talker().create_service(String, 'x', Talker().add)",
    "Talker().create_client(String, 'x')",
    "Talker().adder.call(AddTwoInts.Response())",
    "Talker().adder.call_async(AddTwoInts.Request(c=3))",
    "Talker().adder.call_async(AddTwoInts.Request()).result().sum",
    "Talker().words.callback.nonsense",
    "Talker().declare_parameter('x', {})",
    "Talker().declare_parameter('x', 1, Parameter('x'))",
    "Talker().set_parameters([Parameter('x')])[0].success",
    "Talker().add_on_set_parameters_callback(Talker().hear)",
    "Talker().get_clock().now().to_msg().secs",
    "(Talker().get_clock().now() - Talker().get_clock().now()).clock_type",
    "rclpy.spinn(Talker())",
    "from std_msgs.msg import Strong",
    "from rclpy.node import Knot",
)


GADGET = """
# Fields may be called as Python's builtins.
std_msgs/Header header
float64[3] int
int32[<=4] property
string[] list
int8 class
Gadget[] parts
byte KIND=3
"""


def mypy(folder: Path, python: Path, *files: str) -> str:
    # What mypy has read of the libraries serves the next test as well.
    options = ["--strict", "--python-executable", str(python)]
    options += ["--cache-dir", str(python.parents[1] / "mypy_cache")]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *options, *files],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert not done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def errors(tmp_path_factory, users_python):
    """What mypy says of the node as it is, and of one with the wrong lines, by line."""
    folder = tmp_path_factory.mktemp("program")
    shutil.copy(NODE, folder / "right.py")
    lines = "".join(f"    {line}\n" for line in WRONG)
    text = NODE.read_text(encoding="utf-8")
    head, tail = text.split("    battery.present = True\n")
    wrong = f"{head}{lines}{tail}"
    (folder / "wrong.py").write_text(wrong, encoding="utf-8")
    output = mypy(folder, users_python, "right.py", "wrong.py")
    found: dict[tuple[str, str], list[str]] = {}
    for file, number, message in re.findall(r"^(\w+\.py):(\d+): error: (.*)$", output, re.M):
        source = (text if file == "right.py" else wrong).splitlines()[int(number) - 1].strip()
        found.setdefault((file, source), []).append(message)
    return found


def test_a_node_that_is_right_passes(errors):
    assert not [messages for (file, _), messages in errors.items() if file == "right.py"]


@pytest.mark.parametrize("line", WRONG)
def test_a_wrong_line_is_named(errors, line):
    assert errors.get(("wrong.py", line)), errors


def test_no_other_line_is_named(errors):
    assert {line for file, line in errors if file == "wrong.py"} <= set(WRONG)


def test_ones_own_messages_have_types_where_the_verb_says(tmp_path, users_python):
    package = tmp_path / "gadget_msgs"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>gadget_msgs</name></package>")
    (package / "msg" / "Gadget.msg").write_text(GADGET)
    done = subprocess.run(
        [users_python, "-m", "teleopctl", "interface", "stubs", "typings"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    (tmp_path / "pyproject.toml").write_text(done.stderr[done.stderr.index("[") :])
    (tmp_path / "program.py").write_text(
        "from gadget_msgs.msg import Gadget\n"
        "one = Gadget(int=[1, 2, 3.5], property=(1, 2), list=['a'], class_=Gadget.KIND[0])\n"
        "one.parts = [Gadget(), one]\n"
        "one.header.frame_id = one.list[0]\n"
        "one.parts = [one.header]\n"
        "one.property = ['1']\n"
        "one.klass = 3\n"
    )
    output = mypy(tmp_path, users_python, "program.py", "typings/gadget_msgs/msg.pyi")
    assert re.findall(r"^(\S+?):(\d+): error", output, re.M) == [
        ("program.py", "5"),
        ("program.py", "6"),
        ("program.py", "7"),
    ]
