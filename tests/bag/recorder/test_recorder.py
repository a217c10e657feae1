"""Where a recording goes."""

from __future__ import annotations

import re

from teleopctl.bag import default_bag_folder


def test_recordings_of_the_same_second_have_folders_of_their_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("time.strftime", lambda _: "rosbag2_2026_11_22-13_24_34")
    names = []
    for _ in range(3):
        folder = default_bag_folder()
        folder.mkdir()
        names.append(folder.name)
    assert names[0] == "rosbag2_2026_11_22-13_24_34"
    assert all(re.fullmatch(rf"{names[0]}_\d", name) for name in names[1:])
    assert len(set(names)) == 3
