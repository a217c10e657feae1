"""``teleopctl top`` over real processes, driven by its keys in a terminal of textual's own."""

import asyncio
import contextlib
import threading
import time

import pytest
from textual.widgets import Static

from teleopctl.cli.command_node import command_node
from teleopctl.cli.verbs.top.app import Top
from teleopctl.cli.verbs.top.screens import Confirm, TextInput
from teleopctl.cli.verbs.top.table import LiveTable
from teleopctl.interfaces import get_message
from teleopctl.testing import LONGEST_WAIT_S
from tests.samples import sample

STRING = get_message("std_msgs/msg/String")
IMAGE = get_message("sensor_msgs/msg/Image")
TWIST = get_message("geometry_msgs/msg/Twist")


class Screen:
    """The app, its keys, and what stands on it."""

    def __init__(self, app, pilot):
        self.app = app
        self.press = pilot.press
        self._pilot = pilot

    async def until(self, answer):
        deadline = time.monotonic() + LONGEST_WAIT_S
        while not (found := answer()):
            assert time.monotonic() < deadline, self.app.export_screenshot(simplify=True)
            await self._pilot.pause(0.05)
        return found

    def row(self, name):
        """The cells of the row whose first one this is; None if there is none."""
        for index in range(self.app.table.row_count):
            cells = [str(cell) for cell in self.app.table.get_row_at(index)]
            if cells[0] == name:
                return cells
        return None

    async def go_to(self, name):
        await self.until(lambda: self.row(name))
        table = self.app.table
        names = [str(table.get_row_at(index)[0]) for index in range(table.row_count)]
        table.move_cursor(row=names.index(name))
        await self._pilot.pause()

    def text(self, selector):
        return str(self.app.screen.query_one(selector, Static).content)

    async def opened(self, kind):
        await self.until(lambda: isinstance(self.app.screen, kind))


def on_screen(scenario, size=(120, 30)):
    """Run a scenario, which is told the screen."""

    async def run():
        with command_node() as node:
            app = Top(node, period_s=0.1)
            async with app.run_test(size=size) as pilot:
                await scenario(Screen(app, pilot))

    asyncio.run(run())


@contextlib.contextmanager
def publishing(ros, message, topic, rate=20.0):
    """A publisher of the test's that sends again and again."""
    publisher = ros.node.create_publisher(type(message), topic, 10)
    sending = threading.Lock()
    ended = False

    def send():
        with sending:
            if not ended:
                publisher.publish(message)

    timer = ros.node.create_timer(1.0 / rate, send)
    yield publisher
    # A call that has begun on the node's thread comes to its end first.
    with sending:
        ended = True
    ros.node.destroy_timer(timer)
    ros.node.destroy_publisher(publisher)


def test_a_node_is_shown_with_its_process_wherever_it_was_started(ros_with_own_router):
    ros = ros_with_own_router
    process = ros.spawn("run teleop_py_pkg simple_publisher")
    ros.run("run -d teleop_py_pkg simple_subscriber")

    async def scenario(screen):
        name, cpu, memory, pid, _ = await screen.until(
            lambda: (row := screen.row("/simple_publisher")) and row[1] and row
        )
        assert (name, int(pid)) == ("/simple_publisher", process.pid)
        assert float(cpu) >= 0.0
        assert memory.endswith("MB")
        row = await screen.until(lambda: screen.row("/simple_subscriber"))
        assert row[4] == "simple_subscriber"
        assert await screen.until(lambda: screen.row("(router)"))
        process.interrupt()
        await screen.until(lambda: not screen.row("/simple_publisher"))

    on_screen(scenario)


@pytest.mark.nightly
def test_topics_are_measured_while_they_are_on_the_screen(ros):
    async def scenario(screen):
        with publishing(ros, STRING(data="x" * 100), "/chatter") as publisher:
            await screen.until(lambda: screen.row("/test") or screen.app.table.row_count)
            assert publisher.get_subscription_count() == 0
            await screen.press("2")
            row = await screen.until(
                lambda: (row := screen.row("/chatter")) and float(row[1]) > 5 and row
            )
            assert row[2].endswith("B/s")
            assert row[3].endswith("ms")
            assert row[4:] == ["1", "0", "std_msgs/msg/String"]
            await screen.press("1")
            await screen.until(lambda: publisher.get_subscription_count() == 0)

    on_screen(scenario)


@pytest.mark.nightly
def test_pictures_are_measured_when_they_are_asked_for(ros):
    async def scenario(screen):
        with publishing(ros, IMAGE(), "/image") as publisher:
            await screen.press("2")
            row = await screen.until(lambda: screen.row("/image"))
            assert row[1] == "m: look"
            assert publisher.get_subscription_count() == 0
            await screen.go_to("/image")
            await screen.press("m")
            await screen.until(lambda: "look" not in (row := screen.row("/image"))[1] and row[3])

    on_screen(scenario)


def test_e_shows_the_latest_message(ros):
    async def scenario(screen):
        with publishing(ros, STRING(data="hello \x1b[31m"), "/chatter"):
            await screen.press("2")
            await screen.go_to("/chatter")
            await screen.press("e")
            await screen.until(lambda: "data: " in screen.text("#content"))
            assert "\x1b" not in screen.text("#content")
            await screen.press("escape")
            assert await screen.until(lambda: screen.row("/chatter"))

    on_screen(scenario)


@pytest.mark.nightly
def test_g_draws_fields_over_time(ros):
    async def scenario(screen):
        message = TWIST()
        message.linear.x = 1.5
        with publishing(ros, message, "/cmd_vel"):
            await screen.press("2")
            await screen.go_to("/cmd_vel")
            await screen.press("g")
            await screen.opened(TextInput)
            await screen.press(*"linear.x, angular.z", "enter")
            await screen.until(lambda: "angular.z" in screen.text("#content"))
            assert "-10 s" in screen.text("#content")
            await screen.press("minus")
            await screen.until(lambda: "-5 s" in screen.text("#content"))

    on_screen(scenario)


@pytest.mark.nightly
def test_a_field_that_is_wrong_is_told(ros):
    async def scenario(screen):
        with publishing(ros, TWIST(), "/cmd_vel"):
            await screen.press("2")
            await screen.go_to("/cmd_vel")
            await screen.press("g")
            await screen.opened(TextInput)
            await screen.press(*"linear.w", "enter")
            await screen.until(lambda: "no field 'w'" in screen.text("#content"))

    on_screen(scenario)


def test_p_lists_parameters_and_enter_sets_one(ros):
    ros.spawn("run teleop_py_pkg simple_parameter")

    async def scenario(screen):
        await screen.go_to("/simple_parameter")
        await screen.press("p")
        table = await screen.until(lambda: (t := parameters(screen)) and t.row_count and t)
        names = [str(table.get_row_at(index)[0]) for index in range(table.row_count)]
        table.move_cursor(row=names.index("simple_int_param"))
        await screen.press("enter")
        await screen.opened(TextInput)
        await screen.press("backspace", "backspace", *"99", "enter")
        await screen.until(lambda: shown(table, "simple_int_param") == "99")

    on_screen(scenario)
    assert ros.run("param get /simple_parameter simple_int_param").stdout.endswith(": 99\n")


def parameters(screen):
    found = screen.app.screen.query("#parameters")
    return found.first(LiveTable) if found else None


def shown(table, name):
    for index in range(table.row_count):
        cells = [str(cell) for cell in table.get_row_at(index)]
        if cells[0] == name:
            return cells[1]
    return None


def test_s_stops_a_process_after_a_question(ros):
    ros.run("run -d teleop_py_pkg simple_publisher")
    foreign = ros.spawn("run teleop_py_pkg simple_subscriber")

    async def scenario(screen):
        await screen.go_to("/simple_publisher")
        await screen.press("s")
        await screen.opened(Confirm)
        await screen.press("n")
        assert screen.row("/simple_publisher")
        for name in ("/simple_publisher", "/simple_subscriber"):
            await screen.go_to(name)
            await screen.press("s")
            await screen.opened(Confirm)
            await screen.press("y")
            await screen.until(lambda name=name: not screen.row(name))

    on_screen(scenario)
    assert foreign.wait() in (0, 130)
    assert "simple_publisher" not in ros.run("ps").stdout


def test_the_log_has_what_nodes_say_by_level(ros):
    async def scenario(screen):
        await screen.press("4")
        ros.node.get_logger().info("all is well")
        ros.node.get_logger().error("all is lost")
        await screen.until(lambda: texts(screen)[:2] == ["all is lost", "all is well"])
        await screen.press("l")
        await screen.until(lambda: texts(screen) == ["all is lost"])

    on_screen(scenario)


def texts(screen):
    table = screen.app.table
    return [str(table.get_row_at(index)[-1]) for index in range(table.row_count)]


@pytest.mark.nightly
def test_slash_narrows_the_rows(ros):
    async def scenario(screen):
        with publishing(ros, STRING(), "/left"), publishing(ros, STRING(), "/right"):
            await screen.press("2")
            await screen.until(lambda: screen.row("/right"))
            await screen.press("slash")
            await screen.opened(TextInput)
            await screen.press(*"left", "enter")
            await screen.until(lambda: not screen.row("/right"))
            assert screen.row("/left")
            assert "'left'" in screen.text("#summary")

    on_screen(scenario)


@pytest.mark.nightly
@pytest.mark.parametrize("size", sample([(40, 10), (60, 24), (200, 50)], 3))
def test_columns_fit_the_terminal(ros, size):
    async def scenario(screen):
        with publishing(ros, STRING(), "/a_topic_with_a/name_that_is/longer_than_most/chatter"):
            for key in "1234":
                await screen.press(key)
                await screen.until(lambda: screen.app.table.columns)
                table = screen.app.table
                widths = [column.get_render_width(table) for column in table.columns.values()]
                assert sum(widths) <= size[0]
            await screen.press("2")
            name = await screen.until(lambda: next(iter(names(screen, "chatter")), None))
            assert name.startswith("/a_topic" if size[0] == 200 else "…")

    on_screen(scenario, size)


def names(screen, part):
    table = screen.app.table
    rows = [str(table.get_row_at(index)[0]) for index in range(table.row_count)]
    return [row for row in rows if part in row]


@pytest.mark.nightly
def test_controllers_are_shown_with_their_state(ros):
    ros.launch("controller.yaml")

    async def scenario(screen):
        await screen.press("3")
        row = await screen.until(lambda: screen.row("joint_state_broadcaster"))
        assert row[1] == "active"
        assert row[-1] == "/controller_manager"
        # How long an update takes on average, and took at most.
        row = await screen.until(
            lambda: (row := screen.row("joint_state_broadcaster")) and row[3] and row
        )
        assert row[3].endswith("s")
        assert row[4].endswith("s")

    on_screen(scenario)


@pytest.mark.parametrize("key", ["q", "ctrl+c"])
def test_q_and_ctrl_c_end_it(ros_with_own_router, key):
    async def scenario(screen):
        await screen.until(lambda: screen.app.table.row_count)
        await screen.press(key)
        await screen.until(lambda: not screen.app.is_running)

    on_screen(scenario)


def test_it_needs_a_terminal_and_a_router(ros, ros_without_router):
    done = ros_without_router.run("top")
    assert done.returncode == 2
    assert "terminal" in done.stderr
    assert "topic hz --all" in done.stderr
