"""The folder of the records is the user's own."""

import os
import stat
import sys

import pytest

from teleopctl.base import background
from teleopctl.base.folders import runtime_dir
from teleopctl.errors import SystemFailureError

pytestmark = pytest.mark.skipif(os.name == "nt", reason="owners and modes of POSIX")


@pytest.mark.skipif(sys.platform != "linux", reason="XDG folders")
@pytest.mark.parametrize("mode", [0o755, 0o777, 0o770, None])
def test_a_runtime_folder_that_others_may_use_is_not_used(tmp_path, mode):
    runtime, state = tmp_path / "runtime", tmp_path / "state"
    if mode is not None:
        runtime.mkdir()
        runtime.chmod(mode)
    found = runtime_dir({"XDG_RUNTIME_DIR": str(runtime), "XDG_STATE_HOME": str(state)})
    own = f"/run/user/{os.getuid()}/teleopctl"  # where the machine has it
    assert str(found) in (str(state / "teleopctl"), own)


@pytest.mark.skipif(sys.platform != "linux", reason="XDG folders")
def test_a_runtime_folder_of_the_user_is_used(tmp_path):
    tmp_path.chmod(0o700)
    assert runtime_dir({"XDG_RUNTIME_DIR": str(tmp_path)}) == tmp_path / "teleopctl"


def start():
    sleeps = [sys.executable, "-c", "import time; time.sleep(60)"]
    return background.start("sleeper", sleeps, kind="node")


def test_the_records_are_for_the_user_alone(ros_without_router):
    folder = background.runtime_dir() / "processes"
    folder.mkdir(parents=True)
    folder.chmod(0o777)
    background.stop(start())
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_records_behind_a_link_are_refused(ros_without_router, tmp_path):
    (tmp_path / "of others").mkdir()
    background.runtime_dir().mkdir(parents=True, exist_ok=True)
    (background.runtime_dir() / "processes").symlink_to(tmp_path / "of others")
    for use in (start, background.records):
        with pytest.raises(SystemFailureError, match="is not a folder of your own") as failure:
            use()
        assert failure.value.hint == "Set TELEOPCTL_RUNTIME_DIR to a folder of your own."
    assert list((tmp_path / "of others").iterdir()) == []
    (background.runtime_dir() / "processes").unlink()


def test_records_of_another_user_are_refused(ros_without_router, monkeypatch):
    background.stop(start())
    # This user becomes another one in the eyes of the check: only root could give the folder away.
    with monkeypatch.context() as another_user:
        another_user.setattr(os, "getuid", lambda: 12345)
        with pytest.raises(SystemFailureError, match="is not a folder of your own"):
            background.records()
