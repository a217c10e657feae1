"""How far a process says that it has come."""

import subprocess
import sys

import pytest

from teleopctl.base import progress

TELLER = "from teleopctl.base import progress; progress.report({state!r}, {detail!r})"


def run(log_file, program, *arguments):
    """Run a program that reports to the progress file of a log."""
    subprocess.run(
        [sys.executable, "-c", program, *arguments],
        env={progress.VARIABLE: str(progress.progress_file(log_file))},
        check=True,
    )


def told(log_file, state, detail=""):
    run(log_file, TELLER.format(state=state, detail=detail))
    return progress.read(log_file)


def test_the_last_words_count_on_one_line(tmp_path):
    log_file = tmp_path / "a.log"
    assert progress.read(log_file) is None
    assert told(log_file, progress.STARTING)[:2] == ("starting", "")
    assert told(log_file, progress.FAILED, "two\n lines")[:2] == ("failed", "two lines")


@pytest.mark.parametrize(
    ("reports", "state", "detail", "part"),
    [
        ("WAITING:/a:control STARTING::", "starting", "", ""),
        ("STARTING::control WAITING:/a:", "starting", "", "control"),
        ("READY::control WAITING:/a:", "waiting", "/a", ""),
        ("READY::control READY:localhost:", "ready", "", "control"),
        ("FAILED:refused:control READY::", "failed", "refused", "control"),
        ("FAILED:refused:control READY:: STARTING::control", "starting", "", "control"),
        ("FAILED:refused:control ENDED:0:", "ended", "0 refused", ""),
    ],
)
def test_a_process_of_two_parts_is_ready_when_both_are(tmp_path, reports, state, detail, part):
    log_file = tmp_path / "a.log"
    program = (
        "import sys; from teleopctl.base import progress\n"
        "for word in sys.argv[1:]:\n"
        "    state, detail, part = word.split(':')\n"
        "    progress.report(getattr(progress, state), detail, part=part)\n"
    )
    run(log_file, program, *reports.split())
    said = progress.read(log_file)
    assert said is not None
    assert (said.state, said.detail, said.part) == (state, detail, part)


def test_a_failure_keeps_its_time_while_other_parts_of_the_process_report(tmp_path):
    """The first failure among processes is reported, and another one may be its consequence."""
    log_file = tmp_path / "a.log"
    program = (
        "import os; from teleopctl.base import progress\n"
        "path = os.environ[progress.VARIABLE]\n"
        "progress.report(progress.FAILED, 'refused', part=progress.CONTROL)\n"
        "os.utime(path, (1000, 1000))\n"
        "progress.report(progress.STARTING, 'compiling')\n"
        "progress.report(progress.READY)\n"
    )
    run(log_file, program)
    assert progress.read(log_file) == ("failed", "refused", 1000.0, "control", (), ())


def test_remarks_stay_until_the_end_each_once(tmp_path):
    log_file = tmp_path / "a.log"
    program = (
        "from teleopctl.base import progress\n"
        "progress.remark('one\\n line')\n"
        "progress.report('ready')\n"
        "progress.remark('two')\n"
        "progress.remark('one line')\n"
        "progress.report('ended', '0')\n"
    )
    run(log_file, program)
    said = progress.read(log_file)
    assert said is not None
    assert (said.state, said.reason, said.remarks) == ("ended", None, ("one line", "two"))


def test_a_process_names_its_sessions_without_another_state(tmp_path):
    log_file = tmp_path / "a.log"
    program = (
        "from teleopctl.base import progress\n"
        "progress.report('started')\n"
        "progress.report_session('a1')\n"
        "progress.report_session('b2')\n"
    )
    run(log_file, program)
    said = progress.read(log_file)
    assert said is not None
    assert (said.state, said.sessions, said.remarks) == ("started", ("a1", "b2"), ())


def test_what_a_process_does_is_reported_while_it_starts_and_not_later(tmp_path):
    log_file = tmp_path / "a.log"
    program = (
        "import sys; from teleopctl.base import progress\n"
        "for state in sys.argv[1:]:\n"
        "    progress.report(state)\n"
        "    progress.doing('compiling the model')\n"
    )

    def said_after(*states):
        subprocess.run(
            [sys.executable, "-c", program, *states],
            env={progress.VARIABLE: str(progress.progress_file(log_file))},
            check=True,
        )
        said = progress.read(log_file)
        return said and said[:2]

    assert said_after(progress.STARTED) == ("started", "")
    assert said_after(progress.STARTING) == ("starting", "compiling the model")
    assert said_after(progress.STARTING, progress.READY) == ("ready", "")


@pytest.mark.parametrize(("status", "died"), [("0", False), ("130", False), ("1", True)])
def test_who_ends_well_has_not_died(tmp_path, status, died):
    log_file = tmp_path / "a.log"
    said = told(log_file, progress.ENDED, status)
    assert said.exit_status == int(status)
    assert progress.has_failed(log_file) is died


def test_who_was_killed_has_died_and_who_said_nothing_is_not_known(tmp_path):
    log_file = tmp_path / "a.log"
    assert not progress.has_failed(log_file)
    assert told(log_file, progress.READY).exit_status is None
    assert progress.has_failed(log_file)


def test_nothing_is_written_where_nobody_asked(tmp_path, monkeypatch):
    monkeypatch.delenv(progress.VARIABLE, raising=False)
    monkeypatch.setattr(progress, "_file", None)
    monkeypatch.chdir(tmp_path)
    progress.report(progress.READY)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_to_is_no_error(tmp_path):
    assert told(tmp_path / "gone" / "a.log", progress.READY) is None
