"""The supervisor where the system refuses something: the launch goes on with the rest."""

import sys

from teleopctl.launch.execution.supervisor import Supervisor
from teleopctl.launch.model.plan import LaunchPlan, ProcessPlan

WORKS = ProcessPlan(name="works-1", command=[sys.executable, "-c", "print('done')"])


def test_a_launch_goes_on_while_its_status_cannot_be_written(tmp_path):
    (tmp_path / "processes.json.new").mkdir()
    plan = LaunchPlan(log_directory=tmp_path, processes=[WORKS])
    assert Supervisor(plan, in_background=True).run() == 0
    assert (tmp_path / "works-1.log").read_text().strip() == "done"


def test_a_command_that_no_system_takes_is_one_dead_process(tmp_path, capfd):
    odd = ProcessPlan(name="odd-2", command=[sys.executable, "a\0b"])
    plan = LaunchPlan(log_directory=tmp_path, processes=[WORKS, odd])
    assert Supervisor(plan).run() == 1
    output = capfd.readouterr().out
    assert "[ERROR] [odd-2]: process failed to start: embedded null byte" in output
    assert "[INFO] [works-1]: process has finished cleanly" in output


def test_a_process_whose_log_cannot_be_written_does_not_start(tmp_path, capfd):
    (tmp_path / "works-1.log").mkdir()
    assert Supervisor(LaunchPlan(log_directory=tmp_path, processes=[WORKS])).run() == 1
    assert "[ERROR] [works-1]: process failed to start: " in capfd.readouterr().out
