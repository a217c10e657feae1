"""``launch --show-args`` and ``--print`` of Python launch files."""

from launch import LaunchDescription, LaunchIntrospector
from launch.actions import DeclareLaunchArgument, ExecuteProcess, LogInfo

from teleopctl.launch import describe_arguments

FILE = """
from launch import LaunchDescription
from launch.actions import *
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit
from launch.substitutions import Command, LaunchConfiguration, ThisLaunchFileDir

def generate_launch_description():
    first = ExecuteProcess(cmd=["true"], name="first")
    return LaunchDescription([
        DeclareLaunchArgument("needed", description="A word."),
        DeclareLaunchArgument("one_of", choices=["a", "b"], default_value="a"),
        DeclareLaunchArgument("both", default_value="b", choices=["b"], description="Whether."),
        DeclareLaunchArgument("file", default_value=[ThisLaunchFileDir(), "/it"]),
        DeclareLaunchArgument("dear", default_value=Command("touch touched")),
        GroupAction([DeclareLaunchArgument("rare", default_value="")],
                    condition=IfCondition(LaunchConfiguration("dear"))),
        IncludeLaunchDescription(
            [ThisLaunchFileDir(), "/inner.yaml"], launch_arguments={"given": "1"}.items()),
        first,
        RegisterEventHandler(OnProcessExit(target_action=first, on_exit=[LogInfo(msg="done")])),
    ])
"""


def test_the_arguments_are_told_in_the_words_of_ros_2(tmp_path):
    (tmp_path / "inner.yaml").write_text(
        "launch:\n- arg: {name: given}\n- arg: {name: inner, description: Of the inner one.}\n",
        encoding="utf-8",
    )
    path = tmp_path / "file.launch.py"
    path.write_text(FILE, encoding="utf-8")
    assert "\n".join(describe_arguments(path, {})) == (
        "Arguments (pass arguments as '<name>:=<value>'):\n"
        "\n    'needed':\n        A word.\n"
        "\n    'one_of':\n        One of: ['a', 'b']\n        (default: 'a')\n"
        "\n    'both':\n        Whether. Valid choices are: ['b']\n        (default: 'b')\n"
        "\n    'file':\n        no description given\n"
        "        (default: ThisLaunchFileDir() + '/it')\n"
        "\n    'dear':\n        no description given\n        (default: Command('touch touched'))\n"
        "\n    'rare':*\n        no description given\n        (default: '')\n"
        "\n    'inner':\n        Of the inner one.\n"
        "\n* argument(s) which are only used if specific conditions occur"
    )


def test_what_waits_for_a_process_is_told_with_its_name(ros_without_router):
    (ros_without_router.folder / "inner.yaml").write_text("launch: []\n", encoding="utf-8")
    (ros_without_router.folder / "file.launch.py").write_text(FILE, encoding="utf-8")
    done = ros_without_router.run("launch --print file.launch.py needed:=1 given:=1 dear:=false")
    assert done.stdout == "first-1:\n  true\nOnProcessExit(first-1):\n  done\n", done.stderr


def test_a_description_is_told_as_a_tree():
    description = LaunchDescription(
        [LogInfo(msg=["a", "b"]), ExecuteProcess(cmd=["ls"]), DeclareLaunchArgument("x")]
    )
    told = LaunchIntrospector().format_launch_description(description).splitlines()
    assert told[1:3] == [
        "├── LogInfo('a' + 'b')",
        "├── ExecuteProcess(cmd=['ls'], cwd=None, env=None, shell=False)",
    ]
    assert told[3].startswith("└── Action('")
