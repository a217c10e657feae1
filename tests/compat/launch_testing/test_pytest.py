"""Launch tests under pytest: files of ``launch_testing``, and functions of ``launch_pytest``."""

import textwrap

import pytest

from tests import LEAN_PYTEST
from tests.samples import sample

LAUNCH_TEST = """
import sys
import unittest

import launch_testing
import pytest
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration

@pytest.mark.{mark}
@launch_testing.markers.keep_alive
def generate_test_description():
    echo = [sys.executable, "-c", "import sys; print(sys.argv[1])", LaunchConfiguration("word")]
    return LaunchDescription([
        DeclareLaunchArgument("word", default_value="none"),
        ExecuteProcess(cmd=echo, name="echo"),
        launch_testing.actions.ReadyToTest(),
    ])

class TestIt(unittest.TestCase):
    def test_it_says_a_word(self, proc_output):
        proc_output.assertWaitFor("hello", stream="stdout", timeout={timeout})
"""

LAUNCH_PYTEST = """
import sys

import launch_pytest
import launch_testing
import pytest
from launch import LaunchDescription
from launch.actions import ExecuteProcess
from launch_pytest.tools import process as tools

order = []

@pytest.fixture
def talks():
    code = "import sys; print('out'); print('err', file=sys.stderr); sys.exit(3)"
    return ExecuteProcess(cmd=[sys.executable, "-c", code], cached_output=True)

@launch_pytest.fixture
def description(talks):
    return LaunchDescription([talks, launch_testing.util.KeepAliveProc()])

@pytest.mark.launch(fixture=description)
def test_a_function(talks, launch_context):
    assert tools.wait_for_start_sync(launch_context, talks, timeout=20)
    assert tools.wait_for_output_sync(launch_context, talks, lambda text: "out" in text, timeout=20)
    assert tools.wait_for_exit_sync(launch_context, talks, timeout=20)
    assert talks.return_code == 3
    yield
    assert launch_context.is_shutdown

@pytest.mark.launch(fixture=description)
async def test_a_coroutine(talks, launch_context):
    def says(word):
        def check(text):
            assert word in text
        return check
    await tools.assert_output(launch_context, talks, says("out"), timeout=20)
    await tools.assert_stderr(launch_context, talks, says("err"), timeout=20)
    assert await tools.wait_for_exit(launch_context, talks, timeout=20)
    with pytest.raises(AssertionError, match="never"):
        await tools.assert_output(launch_context, talks, says("never"), timeout=0)

@launch_pytest.fixture(scope="module", params=["a", "b"])
def shared(request):
    return LaunchDescription([launch_testing.util.KeepAliveProc()]), request.param

@pytest.mark.launch(fixture=shared, shutdown=True)
def test_behind(shared, launch_service):
    order.append(f"behind {shared[1]}")
    assert launch_service.task is None

@pytest.mark.launch(fixture=shared)
async def test_both(shared):
    order.append(f"before {shared[1]}")
    yield
    order.append(f"after {shared[1]}")

class TestInAClass:
    @pytest.mark.launch(fixture=shared)
    def test_beside(self, shared, launch_service):
        order.append(f"beside {shared[1]}")
        assert launch_service.task is not None

def test_order():
    assert order == [
        "before a", "beside a", "behind a", "after a",
        "before b", "beside b", "behind b", "after b",
    ]
"""

WRONG = """
import launch_pytest
import pytest
from launch import LaunchDescription
from launch.actions import OpaqueFunction, Shutdown

@launch_pytest.fixture
def nothing():
    return None

@pytest.mark.launch(fixture=nothing)
def test_no_description():
    pass

def fails(context):
    raise ValueError("no such robot")

@launch_pytest.fixture
def broken():
    return LaunchDescription([OpaqueFunction(function=fails)])

@pytest.mark.launch(fixture=broken)
def test_launch_that_fails():
    pass

@launch_pytest.fixture
def empty():
    return LaunchDescription()

@pytest.mark.launch(fixture=empty)
def test_that_fails():
    assert 1 == 2

@pytest.mark.launch(fixture=empty)
def test_that_yields_twice():
    yield
    yield

@pytest.mark.launch
def test_without_a_fixture():
    pass
"""


@pytest.fixture
def run_pytest(shared_ros, tmp_path):
    """Runs pytest in a folder with one test file, and returns status and output."""

    def run(text, *words):
        (tmp_path / "pytest.ini").write_text("[pytest]\n")
        (tmp_path / "test_it.py").write_text(textwrap.dedent(text), encoding="utf-8")
        words = (*LEAN_PYTEST, "-p", "no:cacheprovider", "-rA", "--strict-markers", *words)
        done = shared_ros.run(["python", "-m", "pytest", *words], cwd=tmp_path)
        return done.returncode, done.stdout + done.stderr

    return run


@pytest.mark.parametrize("mark", sample(["launch_test", "rostest"], 2))
def test_a_file_with_a_test_description_is_one_test(run_pytest, mark):
    status, text = run_pytest(
        LAUNCH_TEST.format(mark=mark, timeout=20), "--launch-args", "word:=hello"
    )
    assert status == 0, text
    assert "PASSED test_it.py::test_it" in text
    assert "1 passed" in text


@pytest.mark.nightly
def test_a_failure_names_the_test_and_its_line(run_pytest):
    status, text = run_pytest(LAUNCH_TEST.format(mark="launch_test", timeout=0.1))
    assert status == 1
    assert "FAIL: test_it.TestIt.test_it_says_a_word" in text
    assert "Waiting for output timed out" in text
    assert "[echo-1]: process started" in text


@pytest.mark.nightly
def test_a_description_without_the_mark_is_no_launch_test(run_pytest):
    text = LAUNCH_TEST.replace("@pytest.mark.{mark}\n", "").format(timeout=1)
    status, text = run_pytest(text + "\ndef test_alone():\n    pass\n", "-k", "alone")
    assert status == 0, text
    assert "PASSED test_it.py::test_alone" in text


@pytest.mark.nightly
def test_functions_coroutines_and_generators_run_beside_the_launch_of_a_fixture(run_pytest):
    status, text = run_pytest(LAUNCH_PYTEST, "-W", "error")
    assert status == 0, text
    assert "11 passed" in text


def test_what_goes_wrong_is_told_of_the_test_that_it_concerns(run_pytest):
    status, text = run_pytest(WRONG)
    assert status == 1
    assert "2 failed, 1 skipped, 1 warning, 2 errors" in text
    for said in (
        "TypeError: launch_pytest fixture 'nothing': return value must be either",
        "ValueError: no such robot",
        "the launch service has failed, return code '1'",
        "FAILED test_it.py::test_that_fails",
        "must stop iteration after yielding once",
        '"fixture" keyword argument is required',
    ):
        assert said in text
