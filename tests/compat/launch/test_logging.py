"""``launch.logging``: where lines go and what they look like, beside those of the launch itself."""

import logging
import re

import launch.logging
import pytest

from teleopctl.launch import SCREEN_FORMAT

LINE_WITH_TIME = re.compile(r"\d+\.\d{7} ")


@pytest.fixture
def config(tmp_path):
    """What a launch has set up, with a log folder of its own."""
    launch.logging.reset()
    launch.logging.launch_config.log_dir = str(tmp_path)
    yield launch.logging.launch_config
    launch.logging.reset()


def test_output_loggers_write_where_the_launch_sends_what_processes_write(config, tmp_path, capsys):
    for name in ("screen", "log", "both", "own_log", "full"):
        out, err = launch.logging.get_output_loggers(name, name)
        out.info("%s %s", name, "out")
        err.info("%s %s", name, "err")
    shown = capsys.readouterr().out.splitlines()
    kept = [
        LINE_WITH_TIME.sub("", line)
        for line in (tmp_path / "launch.log").read_text().splitlines(True)
    ]
    assert shown == [
        "screen out",
        "screen err",
        "log err",
        "both out",
        "both err",
        "full out",
        "full err",
    ]
    assert kept == [
        "log out\n",
        "log err\n",
        "both out\n",
        "both err\n",
        "full out\n",
        "full err\n",
    ]
    for name in ("own_log", "full"):
        assert (tmp_path / f"{name}-stdout.log").read_text() == f"{name} out\n"
        assert (tmp_path / f"{name}-stderr.log").read_text() == f"{name} err\n"
        assert (tmp_path / f"{name}.log").read_text() == f"{name} out\n{name} err\n"
    assert len(list(tmp_path.iterdir())) == 7


@pytest.mark.parametrize(
    "wrong", ["nowhere", {"stdin": "log"}, {"stdout": "nowhere"}, {"stdout": {"log", "no"}}, 5]
)
def test_what_is_no_configuration_of_output_is_refused(config, wrong):
    with pytest.raises(ValueError, match=r"nowhere|stdin|no\b|5"):
        launch.logging.get_output_loggers("name", wrong)


def test_whoever_runs_a_launch_chooses_what_its_lines_look_like(shared_ros, monkeypatch):
    monkeypatch.setitem(shared_ros.env, "OVERRIDE_LAUNCH_SCREEN_FORMAT", r"S\t{name}\t{message}")
    monkeypatch.setitem(shared_ros.env, "OVERRIDE_LAUNCH_LOG_FORMAT", "L {levelname} {message}")
    (shared_ros.folder / "says.launch.py").write_text(
        "import launch\n"
        "def generate_launch_description():\n"
        "    launch.logging.get_logger('file').warning('from a %s', 'logger')\n"
        "    return launch.LaunchDescription([launch.actions.LogInfo(msg='from an action')])\n"
    )
    printed = shared_ros.run("launch --print says.launch.py")
    assert "S\tfile\tfrom a logger" in printed.stdout
    logs = shared_ros.folder / "log"
    before = {path.resolve() for path in logs.iterdir()} if logs.exists() else set()
    done = shared_ros.run("launch says.launch.py")
    assert done.stdout.splitlines()[0] == "S\tfile\tfrom a logger"
    assert "S\tlaunch.user\tfrom an action" in done.stdout.splitlines()
    (folder,) = {path.resolve() for path in logs.iterdir()} - before
    assert (logs / "latest").resolve() == folder
    lines = (folder / "launch.log").read_text().splitlines()
    assert "L WARNING from a logger" in lines
    assert "L INFO from an action" in lines


def test_a_format_of_a_launch_file_holds_for_the_lines_of_the_launch_too(config, capsys):
    config.set_screen_format("%(name)s says %(message)s", screen_style="%")
    launch.logging.get_logger("somebody").info("hello")
    assert capsys.readouterr().out == "somebody says hello\n"
    assert SCREEN_FORMAT.line("INFO", "launch", "so do I") == "launch says so do I"
    with pytest.raises(ValueError, match="custom format style"):
        config.set_log_format("default", log_style="%")


def test_handlers_can_be_made_by_the_program(config):
    lines = {}

    class Keeps(launch.logging.handlers.Handler):  # type: ignore[misc]  # made when asked for
        def emit(self, record):
            lines[self.path] = self.format(record)

    def make(path, encoding):
        assert encoding == "utf-8"
        made = Keeps()
        made.path = path
        return made

    config.log_handler_factory = make
    config.level = logging.WARNING
    logger = launch.logging.get_logger("somebody")
    logger.info("nobody hears it")
    assert not lines
    logger.error("loud")
    ((path, line),) = lines.items()
    assert path == config.get_log_file_path()
    assert LINE_WITH_TIME.sub("", line) == "[ERROR] [somebody]: loud"
