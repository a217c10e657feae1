"""Launch tests that ``teleopctl test`` runs: what they are given, and what they end with."""

import textwrap
import xml.etree.ElementTree as ET

import pytest

from tests.samples import sample

HEAD = """
import sys
import unittest

import launch_testing
import launch_testing.actions
import launch_testing.markers
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, RegisterEventHandler, Shutdown
from launch.event_handlers import OnProcessExit
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_testing import asserts
from launch_testing_ros.tools import basic_output_filter
from rclpy.utilities import get_available_rmw_implementations


def python(code, *words, **more):
    return ExecuteProcess(cmd=[sys.executable, "-u", "-c", code, *words], **more)
"""


@pytest.fixture
def launch_test(shared_ros):
    """Runs a file of some lines with ``teleopctl test``, and returns all that it says."""

    def run(body, *words, status=0):
        path = shared_ros.folder / "some_test.py"
        path.write_text(HEAD + textwrap.dedent(body), encoding="utf-8")
        done = shared_ros.run(["test", "some_test.py", *words])
        text = done.stdout + done.stderr
        assert done.returncode == status, text
        return text

    return run


def test_tests_run_beside_the_processes_and_behind_them_with_what_they_ask_for(
    launch_test, shared_ros
):
    launch_test(
        r"""
        TALKS = "import sys\nprint('one', sys.argv[1])\nprint('\\x1b[31mtwo\\x1b[0m')\n"
        WAITS = "import signal, sys\nsignal.signal(signal.SIGINT, lambda *_: sys.exit(3))\n"
        WAITS += "print('ready')\nsignal.pause()\n"


        @launch_testing.parametrize("number", [1, 2])
        def generate_test_description(number):
            waits = python(WAITS, name="waits")
            talks = python(TALKS, LaunchConfiguration("word"), str(number), name="talks")
            ready = launch_testing.event_handlers.StdoutReadyListener(
                target_action=waits, ready_txt="ready",
                actions=[talks, launch_testing.actions.ReadyToTest()],
            )
            argument = DeclareLaunchArgument("word", default_value="none")
            listens = RegisterEventHandler(ready)
            return LaunchDescription([argument, listens, waits]), {"talks": talks}


        class TestBeside(unittest.TestCase):
            @classmethod
            def setUpClass(cls, proc_output):
                cls.output = proc_output

            def setUp(self, number):
                self.number = number

            def test_waits(self, proc_info, proc_output, talks, test_args):
                assert test_args == {"word": "hello"}
                proc_info.assertWaitForShutdown(talks, timeout=20)
                proc_output.assertWaitFor("one hello", talks, str(self.number), stream="stdout")
                assert not proc_output.waitFor("three", "talks", timeout=0, stream="stdout")
                assert self.output is proc_output

            def test_starts_another_process(self, launch_service, proc_info, proc_output):
                more = python("import sys; print(input())", name="more", shell=False)
                only = basic_output_filter(["EOF"], None, *get_available_rmw_implementations())
                with launch_testing.tools.launch_process(
                    launch_service, more, proc_info, proc_output, output_filter=only
                ) as process:
                    assert process.wait_for_shutdown(timeout=20)
                assert process.exit_code == 1
                assert "Traceback" in process.stderr
                assert "EOFError" not in process.stderr


        @launch_testing.post_shutdown_test()
        class TestBehind(unittest.TestCase):
            def test_all_have_ended(self, proc_info, proc_output, talks, number):
                asserts.assertExitCodes(proc_info, process=talks, cmd_args=[str(number)])
                asserts.assertExitCodes(proc_info, [3], "waits")
                with self.assertRaisesRegex(AssertionError, "waits.* exited with code 3"):
                    asserts.assertExitCodes(proc_info)
                with asserts.assertSequentialStdout(proc_output, "talks") as written:
                    written.assertInStdout("one")
                    written.assertInStdout("two")
                    with self.assertRaisesRegex(AssertionError, "one hello"):
                        written.assertInStdout("one")
                asserts.assertInStdout(proc_output, ["one", "two\n"], "talks")
                asserts.assertInStderr(proc_output, "EOFError", "more")
        """,
        *("word:=hello", "--junit-xml", "report.xml", "--package-name", "my_pkg"),
    )
    suites = ET.parse(shared_ros.folder / "report.xml").getroot()
    assert suites.attrib["tests"] == "6"
    assert [suite.attrib["name"] for suite in suites] == [
        "my_pkg.some_test.launch_tests[1]",
        "my_pkg.some_test.launch_tests[2]",
    ]
    cases = [(case.attrib["classname"], case.attrib["name"]) for case in suites[1]]
    assert cases == [
        ("my_pkg.TestBeside", "test_starts_another_process[2]"),
        ("my_pkg.TestBeside", "test_waits[2]"),
        ("my_pkg.TestBehind", "test_all_have_ended[2]"),
    ]


def test_a_failing_test_ends_the_launch_and_is_reported(launch_test, shared_ros):
    text = launch_test(
        """
        @launch_testing.markers.keep_alive
        def generate_test_description():
            said = python("print('said')", name="says")
            return LaunchDescription([said, launch_testing.actions.ReadyToTest()])


        class TestBeside(unittest.TestCase):
            tries = 0

            def test_wrong(self, proc_info):
                proc_info.assertWaitForShutdown("says", timeout=20)
                self.assertEqual(1, 2, "no two numbers")

            @launch_testing.markers.retry_on_failure(times=2)
            def test_right_at_last(self):
                type(self).tries += 1
                self.assertEqual(self.tries, 2)

            @unittest.skip("not today")
            def test_left_out(self):
                pass


        @launch_testing.post_shutdown_test()
        class TestBehind(unittest.TestCase):
            def test_runs_all_the_same(self, proc_info):
                asserts.assertExitCodes(proc_info)
        """,
        *("--junit-xml", "report.xml"),
        status=1,
    )
    assert "no two numbers" in text
    (suite,) = ET.parse(shared_ros.folder / "report.xml").getroot()
    kinds = {case.attrib["name"]: [child.tag for child in case] for case in suite}
    assert kinds == {
        "test_left_out": ["skipped"],
        "test_right_at_last": [],
        "test_wrong": ["failure"],
        "test_runs_all_the_same": [],
    }


def test_a_launch_that_ends_before_its_tests_have_fails_them_with_its_last_words(launch_test):
    text = launch_test(
        """
        def generate_test_description():
            dies = python("import sys; sys.exit('no such arm')", name="dies")
            return LaunchDescription([dies, launch_testing.actions.ReadyToTest()])


        class TestBeside(unittest.TestCase):
            def test_waits(self, proc_output):
                proc_output.assertWaitFor("never", timeout=None)
        """,
        status=1,
    )
    assert "Processes under test stopped before tests completed" in text
    assert "Process 'dies-1' exited with 1\n##### 'dies-1' output #####\nno such arm\n" in text


def test_a_launch_that_does_not_get_ready_is_ended(launch_test):
    text = launch_test(
        """
        @launch_testing.ready_to_test_action_timeout(0.2)
        def generate_test_description():
            never = OnProcessExit(on_exit=[launch_testing.actions.ReadyToTest()])
            return LaunchDescription(
                [launch_testing.util.KeepAliveProc(), RegisterEventHandler(never)]
            )


        class TestBeside(unittest.TestCase):
            def test_nothing(self):
                pass
        """,
        status=1,
    )
    assert "Timed out waiting for processes to start up" in text


@pytest.mark.parametrize(
    ("body", "said"),
    sample(
        [
            (
                "def generate_test_description(ready_fn): ...",
                "unexpected extra argument 'ready_fn'",
            ),
            (
                "def generate_test_description(): return LaunchDescription()",
                "containing a ReadyToTest action",
            ),
            ("def generate_test_description(): return 1 / 0", "some_test.py:20: ZeroDivisionError"),
            ("", "has no function generate_test_description()"),
        ],
        2,
    ),
)
def test_a_file_that_is_no_launch_test_is_refused(launch_test, body, said):
    assert said in launch_test(body, status=1)


def test_the_arguments_of_a_test_are_listed(launch_test):
    text = launch_test(
        """
        def generate_test_description():
            argument = DeclareLaunchArgument("rate", default_value="10", description="Of it.")
            return LaunchDescription([argument, launch_testing.actions.ReadyToTest()])
        """,
        "--show-args",
    )
    assert "\n    'rate':\n        Of it.\n        (default: '10')" in text
    assert "Ran " not in text


def test_nodes_are_launched_and_their_topics_waited_for(launch_test):
    launch_test(
        """
        from launch_testing_ros import WaitForTopics
        from std_msgs.msg import String


        def generate_test_description():
            talker = Node(package="teleop_py_pkg", executable="simple_publisher")
            return LaunchDescription([talker, launch_testing.actions.ReadyToTest()])


        class TestBeside(unittest.TestCase):
            def test_it_talks(self):
                with WaitForTopics([("/chatter", String)], timeout=30.0) as topics:
                    assert topics.received_messages("/chatter")[0].data.startswith("Hello")
                    assert topics.topics_received() == {"/chatter"}

            def test_nobody_talks_elsewhere(self):
                topics = WaitForTopics([("/chatter", String), ("/silent", String)], timeout=0.1)
                assert not topics.wait()
                assert "/silent" in topics.topics_not_received()
                topics.shutdown()
        """
    )


LEGACY = """
import re, sys
from launch import LaunchDescription, LaunchService
from launch.actions import ExecuteProcess
from launch_testing.legacy import LaunchTestService
from launch_testing.legacy.output import create_output_lines_test, create_output_regex_test

def python(code, name):
    return ExecuteProcess(cmd=[sys.executable, "-u", "-c", code], name=name)

description, tests = LaunchDescription(), LaunchTestService()
fixture = python("import time; print('up 1\\\\nup 2'); time.sleep(600)", "fixture")
tests.add_fixture_action(description, fixture)
tests.add_output_test(description, fixture, create_output_lines_test([b"up 1", b"up 2"]))
tests.add_test_action(description, python("import sys; sys.exit(int(sys.argv[1]))".replace(
    "sys.argv[1]", repr(sys.argv[1])), "test"))
service = LaunchService()
service.include_launch_description(description)
sys.exit(tests.run(service))
"""


@pytest.mark.parametrize("status", [0, 4])
def test_processes_that_are_tests_decide_how_a_launch_ends(shared_ros, status):
    path = shared_ros.folder / "legacy.py"
    path.write_text(LEGACY, encoding="utf-8")
    done = shared_ros.run(f"python legacy.py {status}")
    assert done.returncode == status, done.stdout + done.stderr
