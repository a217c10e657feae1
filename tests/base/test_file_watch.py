"""Saved files are noticed, in whatever way an editor saves them."""

import os
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from teleopctl.base.file_watch import FileWatch
from teleopctl.testing import LONGEST_WAIT_S


def overwrite(file: Path) -> None:
    file.write_text("new")


def rename_over(file: Path) -> None:
    new = file.with_suffix(".tmp")
    new.write_text("new")
    new.replace(file)


def remove_and_write(file: Path) -> None:
    file.unlink()
    file.write_text("new")


@pytest.fixture
def noticed():
    return threading.Event()


@pytest.fixture
def watch(noticed):
    watch = FileWatch(lambda _: noticed.set())
    yield watch
    watch.close()


def watched(watch: FileWatch, noticed: threading.Event, file: Path) -> None:
    """Watch a file; what is saved before that has begun is noticed, too."""
    file.write_text("old")
    watch.watch([file])
    file.write_text("newer")
    assert noticed.wait(LONGEST_WAIT_S)
    while noticed.wait(0.5):
        noticed.clear()


@pytest.mark.parametrize("save", [overwrite, rename_over, remove_and_write])
def test_a_save_is_noticed_again_and_again(tmp_path, watch, noticed, save: Callable[[Path], None]):
    file = tmp_path / "robot.xacro"
    watched(watch, noticed, file)
    for _ in range(2):
        save(file)
        assert noticed.wait(LONGEST_WAIT_S)
        while noticed.wait(0.5):
            noticed.clear()


def test_a_link_and_what_it_leads_to_are_both_watched(tmp_path, watch, noticed):
    (tmp_path / "real").mkdir()
    real, link = tmp_path / "real" / "robot.xacro", tmp_path / "robot.xacro"
    real.write_text("old")
    link.symlink_to(real)
    watched(watch, noticed, link)
    rename_over(real)
    assert noticed.wait(LONGEST_WAIT_S)


def test_other_files_in_the_folder_are_not_minded(tmp_path, watch, noticed):
    file = tmp_path / "robot.xacro"
    watched(watch, noticed, file)
    (tmp_path / "other").write_text("new")
    overwrite(file)
    assert noticed.wait(LONGEST_WAIT_S)
    noticed.clear()
    (tmp_path / "other").write_text("newer")
    assert not noticed.wait(1.0)


def test_what_is_not_there_is_no_fault(tmp_path, watch):
    watch.watch([tmp_path / "gone" / "robot.xacro", Path(os.devnull)])
    watch.watch([])
