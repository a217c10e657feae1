"""A Python launch file that runs: events, timers, coroutines, and how it ends."""

import re
import textwrap
from pathlib import Path

import psutil
import pytest

HEAD = """
import asyncio, sys
from launch import LaunchDescription, Event
from launch.actions import *
from launch.event_handlers import *
from launch.events import Shutdown as ShutdownEvent
from launch.events.process import SignalProcess
from launch import EventHandler
from launch.events import matches_action
from launch.substitutions import LocalSubstitution

def says(word, **more):
    return ExecuteProcess(cmd=[sys.executable, "-c", f"print('{word}', flush=True)"],
                          name=word, output="screen", **more)

def waits(**more):
    return ExecuteProcess(cmd=[sys.executable, "-c", "import time; time.sleep(600)"],
                          name="waits", **more)

def tell(*words):
    return LogInfo(msg=list(words))
"""


@pytest.fixture
def launch(shared_ros):
    """Runs a launch file of some lines to its end."""

    def launch(body, status=0):
        path = shared_ros.folder / "file.launch.py"
        path.write_text(HEAD + textwrap.dedent(body), encoding="utf-8")
        done = shared_ros.run("launch file.launch.py")
        assert done.returncode == status, done.stdout + done.stderr
        return done.stdout + done.stderr

    return launch


def in_order(text, *words):
    places = [text.index(word) for word in words]
    assert places == sorted(places), text


def test_one_process_follows_another_and_all_are_told_of_it(launch):
    text = launch(
        """
        first = says("first", cached_output=True)
        second = says("second", log_cmd=True, output_format="{line}")

        def on_exit(event, context):
            return [tell("wrote ", first.get_stdout().strip(), f" {first.return_code}"), second]

        def heard(event):
            return tell("heard ", event.text.decode().strip())

        class Mine(Event):
            name = "mine"

        def generate_launch_description():
            return LaunchDescription([
                first,
                RegisterEventHandler(OnProcessStart(
                    target_action=first,
                    on_start=[tell("started ", LocalSubstitution("event.process_name"))])),
                RegisterEventHandler(OnProcessExit(target_action=first, on_exit=on_exit)),
                RegisterEventHandler(OnProcessIO(target_action=second, on_stdout=heard)),
                RegisterEventHandler(OnExecutionComplete(
                    target_action=second, on_completion=[EmitEvent(event=Mine())])),
                RegisterEventHandler(EventHandler(
                    matcher=event_named("mine"), entities=[tell("mine came")])),
                RegisterEventHandler(OnShutdown(on_shutdown=[tell("ends")])),
            ])
        """
    )
    in_order(text, "started first-1", "wrote first 0", "heard second", "mine came", "ends")
    assert "[INFO] [second-2]: process details: cmd=" in text
    assert text.count("[WARNING] [second-2]: output_format is without effect") == 1


def test_timers_and_coroutines_keep_a_launch_going_until_they_are_cancelled(launch):
    text = launch(
        """
        later = TimerAction(period=3600.0, actions=[tell("never")])
        soon = TimerAction(period=0.01, actions=[tell("soon")])

        async def coroutine(context, word):
            await asyncio.sleep(0)
            await context.emit_event(Event())
            context.launch.log("INFO", word)
            later.cancel()

        async def endless():
            await asyncio.Event().wait()

        def generate_launch_description():
            return LaunchDescription([
                later, soon,
                OpaqueCoroutine(coroutine=endless, ignore_context=True),
                RegisterEventHandler(OnExecutionComplete(
                    target_action=soon,
                    on_completion=[OpaqueCoroutine(coroutine=coroutine, args=["went on"])])),
                RegisterEventHandler(EventHandler(
                    matcher=lambda event: type(event) is Event, handle_once=True,
                    entities=[tell("event of a coroutine"), Shutdown(reason="enough")])),
            ])
        """
    )
    in_order(text, "soon", "event of a coroutine")
    assert "never" not in text


@pytest.mark.parametrize(
    "wrong",
    [
        "RegisterEventHandler(OnProcessStart(on_start=fails))",
        "OpaqueCoroutine(coroutine=fails_later)",
    ],
)
def test_what_fails_later_ends_the_launch_with_its_line(launch, wrong):
    text = launch(
        f"""
        def fails(event, context):
            raise ValueError("no such thing")

        async def fails_later(context):
            raise ValueError("no such thing")

        def generate_launch_description():
            return LaunchDescription([{wrong}, waits()])
        """,
        status=1,
    )
    assert "Caught exception in launch: " in text
    assert "file.launch.py:" in text
    assert "ValueError: no such thing" in text
    assert "[INFO] [waits-1]: process started" in text


def test_what_fails_at_the_start_starts_nothing(launch):
    text = launch(
        """
        def fails(context):
            raise RuntimeError("no such thing")

        def generate_launch_description():
            return LaunchDescription([waits(), OpaqueFunction(function=fails)])
        """,
        status=1,
    )
    assert "no such thing" in text
    assert "process started" not in text


def test_ctrl_c_ends_a_chain_that_is_under_way(shared_ros):
    path = shared_ros.folder / "chain.launch.py"
    path.write_text(
        HEAD
        + textwrap.dedent("""
        first, second = says("first"), says("second")

        def generate_launch_description():
            return LaunchDescription([
                first,
                RegisterEventHandler(OnProcessExit(target_action=first, on_exit=[second])),
                RegisterEventHandler(OnProcessExit(target_action=second, on_exit=[
                    TimerAction(period=0.0, actions=[ExecuteProcess(
                        cmd=[sys.executable, "-c", "import time; print('third', flush=True); "
                             "time.sleep(600)"], name="third", output="screen")])])),
                RegisterEventHandler(OnShutdown(
                    on_shutdown=lambda event, _: tell(f"by a person: {event.due_to_sigint}"))),
            ])
        """),
        encoding="utf-8",
    )
    launch = shared_ros.spawn("launch chain.launch.py")
    launch.wait_for_line(r"^\[third-3\] third$")
    launch.interrupt()
    launch.wait_for_line(r"by a person: True$")
    assert launch.wait() == 0


@pytest.mark.nightly
def test_two_hundred_processes_start_and_all_end_on_ctrl_c(shared_ros):
    path = shared_ros.folder / "many.launch.py"
    path.write_text(
        HEAD
        + textwrap.dedent("""
        def generate_launch_description():
            return LaunchDescription(
                [ExecuteProcess(cmd=["sleep", "600"], name="many") for _ in range(200)]
            )
        """),
        encoding="utf-8",
    )
    launch = shared_ros.spawn("launch many.launch.py")
    launch.wait_for_line(r"\[many-200\]: process started")
    launch.interrupt()
    assert launch.wait() == 0
    pids = re.findall(r"\[many-\d+\]: process started with pid \[(\d+)\]", launch.stdout)
    assert len(pids) == len(re.findall("process has finished cleanly", launch.stdout)) == 200
    assert not any(psutil.pid_exists(int(pid)) for pid in pids)


def test_ctrl_c_is_heard_while_a_function_of_the_file_takes_its_time(shared_ros):
    path = shared_ros.folder / "slow.launch.py"
    path.write_text(
        HEAD
        + textwrap.dedent("""
        import time

        def takes_long(context):
            print("begun", flush=True)
            time.sleep(600)

        def generate_launch_description():
            return LaunchDescription([
                ExecuteProcess(cmd=["sleep", "600"], name="waits"),
                TimerAction(period=0.0, actions=[OpaqueFunction(function=takes_long)]),
            ])
        """),
        encoding="utf-8",
    )
    launch = shared_ros.spawn("launch slow.launch.py")
    launch.wait_for_line(r"^begun$")
    launch.interrupt()
    launch.wait_for_line(r"\[waits-1\]: process has finished cleanly")
    assert launch.wait() == 0


def test_ctrl_c_that_a_launch_file_swallows_ends_the_launch_before_it_starts_anything(shared_ros):
    (shared_ros.folder / "swallows.launch.py").write_text(
        HEAD
        + textwrap.dedent("""
        import signal

        try:
            signal.raise_signal(signal.SIGINT)
        except:
            print("caught", flush=True)

        def generate_launch_description():
            return LaunchDescription([waits()])
        """),
        encoding="utf-8",
    )
    done = shared_ros.run("launch swallows.launch.py")
    assert (done.returncode, done.stdout) == (130, "caught\n")


def test_a_program_launches_by_a_service_of_its_own(shared_ros):
    (shared_ros.folder / "program.py").write_text(
        HEAD
        + textwrap.dedent("""
        from launch import LaunchService

        service = LaunchService()
        service.include_launch_description(LaunchDescription([
            says("hello"),
            RegisterEventHandler(OnProcessExit(on_exit=lambda *_: service.shutdown())),
        ]))
        print("status", service.run(shutdown_when_idle=False))
        asyncio.run(service.run_async())
        """),
        encoding="utf-8",
    )
    done = shared_ros.run("python program.py")
    assert done.returncode == 0, done.stderr
    in_order(done.stdout, "[hello-1] hello", "status 0")


def test_what_a_launch_file_leaves_among_the_temporary_files_goes_with_the_launch(launch):
    text = launch(
        """
        import tempfile
        with tempfile.NamedTemporaryFile("w", suffix=".params", delete=False) as file:
            file.write("gain: 7")

        def generate_launch_description():
            return LaunchDescription([tell("file ", file.name), says_file(file.name)])

        def says_file(name):
            return ExecuteProcess(
                cmd=[sys.executable, "-c", f"print(open({name!r}).read())"], output="screen"
            )
        """
    )
    assert "gain: 7" in text
    path = re.search(r"file (\S+\.params)", text)
    assert path is not None
    assert not Path(path[1]).parent.exists()


def test_each_shutdown_of_a_launch_that_ends_already_is_an_event_with_its_reason(launch):
    text = launch(
        """
        def generate_launch_description():
            return LaunchDescription([
                TimerAction(period=0.0, actions=[Shutdown(reason="first")]),
                TimerAction(period=0.2, actions=[Shutdown(reason="second")],
                            cancel_on_shutdown=False),
                RegisterEventHandler(OnShutdown(on_shutdown=lambda event, context: [
                    tell("told of the ", event.reason), Shutdown(reason="third")])),
            ])
        """
    )
    in_order(text, "told of the first", "told of the second")
    assert "told of the third" not in text


def test_a_program_whose_loop_ends_before_its_launch_ends_the_launch(shared_ros):
    (shared_ros.folder / "program.py").write_text(
        HEAD
        + textwrap.dedent(
            """
            from launch import LaunchService

            async def main():
                started = asyncio.Event()
                loop = asyncio.get_running_loop()
                service = LaunchService()
                service.include_launch_description(LaunchDescription([
                    waits(),
                    RegisterEventHandler(OnProcessStart(on_start=lambda event, context:
                        print("pid", event.pid, flush=True)
                        or loop.call_soon_threadsafe(started.set) and None))]))
                loop.create_task(service.run_async())
                await started.wait()

            asyncio.new_event_loop().run_until_complete(main())
            """
        ),
        encoding="utf-8",
    )
    done = shared_ros.run("python program.py")
    assert done.returncode == 0, done.stderr
    (pid,) = re.findall(r"^pid (\d+)", done.stdout, re.MULTILINE)
    assert not psutil.pid_exists(int(pid))
