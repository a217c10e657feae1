"""What tests leave running ends with them, however they end."""

from __future__ import annotations

import os
import subprocess
import sys

import psutil
import pytest

from teleopctl.testing import eventually
from tests import ROOT
from tests.reaper import watch_over

TESTER = """
import subprocess, sys
from pathlib import Path
from tests.reaper import watch_over
folder = Path(sys.argv[1])
reaper = watch_over(folder)
sleeper = subprocess.Popen(
    [sys.executable, "-c", "import time; time.sleep(600)"],
    env={"HOME": str(folder)},
    start_new_session=True,
)
print(sleeper.pid, flush=True)
sys.stdin.read()
reaper.communicate()
"""


@pytest.mark.parametrize("is_killed", [True, False], ids=["killed", "in order"])
def test_a_process_that_tests_leave_ends_with_them_and_their_folder_goes(tmp_path, is_killed):
    folder = tmp_path / "folder"
    folder.mkdir()
    with subprocess.Popen(
        [sys.executable, "-c", TESTER, str(folder)],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as tester:
        assert tester.stdin is not None
        assert tester.stdout is not None
        sleeper = psutil.Process(int(tester.stdout.readline()))
        if is_killed:
            tester.kill()
        tester.stdin.close()
        eventually(lambda: not _runs(sleeper), what="the end of what was left")
        eventually(lambda: not folder.exists(), what="the end of the folder")


def test_the_processes_of_a_worker_end_when_the_main_process_is_killed(tmp_path):
    """A worker has a folder of its own; that of the main process is in its environment."""
    main, worker = tmp_path / "main", tmp_path / "worker"
    for folder in (main, worker):
        folder.mkdir()
    with subprocess.Popen(
        [sys.executable, "-c", TESTER, str(worker)],
        env=os.environ | {"PYTHONPATH": str(ROOT), "HOME": str(main)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as tester:
        assert tester.stdin is not None
        assert tester.stdout is not None
        sleeper = psutil.Process(int(tester.stdout.readline()))
        watch_over(main).communicate()
        eventually(lambda: not _runs(sleeper), what="the end of what was left")
        eventually(lambda: not worker.exists(), what="the end of the worker's folder")
        assert tester.wait() != 0


def _runs(process: psutil.Process) -> bool:
    try:
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False
