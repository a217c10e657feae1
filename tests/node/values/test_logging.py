"""Log lines look like rcutils's, and levels and filters decide which come through."""

import subprocess
import sys

from teleopctl.node import ClockType, LoggingSeverity, ROSClock, Time, get_logger


def log_of(code, **env):
    import os

    program = (
        "from teleopctl.node.values import logging\n"
        f"logger = logging.get_logger('arm.left')\n{code}"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, **env},
    )
    assert done.stdout == ""
    return done.stderr.splitlines()


def test_a_line_has_severity_time_name_and_text():
    import re

    (line,) = log_of("logger.info('moving')")
    assert re.fullmatch(r"\[INFO\] \[\d+\.\d{9}\] \[arm\.left\]: moving", line)


def test_the_level_is_inherited_from_the_parent():
    lines = log_of(
        "logging.set_logger_level('arm', 40)\nlogger.warning('no')\nlogger.error('yes')\n"
        "logger.set_level(10)\nlogger.debug('now')"
    )
    assert [line.rsplit(": ")[1] for line in lines] == ["yes", "now"]


def test_once_and_throttle_count_by_line():
    lines = log_of(
        "for i in range(5):\n"
        "    logger.info(f'once {i}', once=True)\n"
        "    logger.info(f'rare {i}', throttle_duration_sec=60.0)\n"
        "    logger.info(f'not the first {i}', skip_first=True) if i < 2 else None\n"
    )
    assert [line.rsplit(": ")[1] for line in lines] == ["once 0", "rare 0", "not the first 1"]


def test_the_format_and_the_colours_follow_the_environment():
    (line,) = log_of("logger.error('x')", RCUTILS_CONSOLE_OUTPUT_FORMAT="{name}|{message}")
    assert line == "arm.left|x"
    (line,) = log_of(
        "logger.error('x')",
        RCUTILS_CONSOLE_OUTPUT_FORMAT="{message}",
        RCUTILS_COLORIZED_OUTPUT="1",
    )
    assert line == "\x1b[31mx\x1b[0m"


def test_filters_are_asked_in_rclpys_order_and_by_the_clock_that_is_given():
    clock, logger, passed = ROSClock(), get_logger("filters"), []
    clock.set_simulated(True)
    for second in (5, 6, 7, 9):
        clock.set_ros_time_override(Time(seconds=second, clock_type=ClockType.ROS_TIME))
        passed.append(
            logger.log(
                "often",
                LoggingSeverity.INFO,
                throttle_duration_sec=2.0,
                throttle_time_source_type=clock,
                skip_first=True,
            )
        )
    assert passed == [False, False, True, True]
    once = [logger.log("two", LoggingSeverity.INFO, skip_first=True, once=True) for _ in range(4)]
    assert once == [False, True, False, False]
