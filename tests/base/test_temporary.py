"""Temporary folders and the processes that made them."""

import os
import signal
import subprocess
import sys

import pytest

from teleopctl.base import temporary
from teleopctl.base.temporary import TemporaryFolder, remove_abandoned

MAKE = """
import sys, time
from pathlib import Path
from teleopctl.base.temporary import TemporaryFolder
folder = TemporaryFolder(Path(sys.argv[1]))
(folder.path / "file").write_text("x")
print(folder.path, flush=True)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def _no_grace(monkeypatch):
    monkeypatch.setattr(temporary, "_MADE_WITHIN_S", -1.0)


@pytest.fixture
def owner(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-c", MAKE, tmp_path],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline().strip()
        yield process
        process.kill()


def test_a_folder_goes_with_its_block(tmp_path):
    with TemporaryFolder(tmp_path) as folder:
        (folder / "file").touch()
        if sys.platform != "win32":
            assert folder.stat().st_mode & 0o777 == 0o700
    assert list(tmp_path.iterdir()) == []


def test_that_of_a_killed_process_goes_with_the_next(tmp_path, owner):
    with TemporaryFolder(tmp_path):
        assert len(list(tmp_path.iterdir())) == 2
    owner.kill()
    owner.wait()
    with TemporaryFolder(tmp_path) as folder:
        assert list(tmp_path.iterdir()) == [folder]


def test_it_stays_as_long_as_it_is_needed(tmp_path, owner):
    owner.send_signal(signal.SIGTERM)
    owner.wait()
    remove_abandoned(tmp_path, lambda pid: pid == owner.pid)
    assert len(list(tmp_path.iterdir())) == 1
    remove_abandoned(tmp_path, lambda pid: pid == os.getpid())
    assert list(tmp_path.iterdir()) == []


def test_what_others_have_there_stays(tmp_path):
    (tmp_path / "teleopctl-x-y").mkdir()
    (tmp_path / "teleopctl-1").mkdir()
    (tmp_path / "teleopctl-1-file").touch()
    (tmp_path / "aim").mkdir()
    (tmp_path / "teleopctl-1-link").symlink_to(tmp_path / "aim")
    remove_abandoned(tmp_path)
    assert len(list(tmp_path.iterdir())) == 5
