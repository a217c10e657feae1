"""``bag check | recover | reindex``: what they print, and their exit status."""

from __future__ import annotations

import json

import pytest

from teleopctl.bag import WriterOptions
from teleopctl.cli import main
from tests.bag.bags import write_bag


@pytest.fixture
def bag(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    write_bag(tmp_path / "bag", topics=1, options=WriterOptions(chunk_bytes=400))
    return tmp_path / "bag"


def run(line: str) -> int:
    return main.run(["bag", *line.split()])


def test_a_whole_bag_is_called_whole(bag, capsys):
    assert run("check bag") == 0
    assert run("recover bag") == 0
    assert capsys.readouterr().out == (
        "bag: nothing is wrong\nbag is whole\nbag has 100 messages\n"
    )


def test_what_was_cut_off_is_finished_in_place(bag, capsys):
    file = bag / "bag_0.mcap"
    file.write_bytes(file.read_bytes()[:2000])
    assert run("check bag") == 1
    assert "bag/bag_0.mcap: it has no end, and " in capsys.readouterr().out
    assert run("recover bag") == 0
    done = capsys.readouterr().out.splitlines()
    assert done[0].startswith("bag/bag_0.mcap: it is finished now, with ")
    assert done[1] == "bag/metadata.yaml: rebuilt from the files"
    assert run("check bag") == 0


def test_what_is_damaged_is_saved_beside_it_and_the_loss_told(bag, capsys):
    file = bag / "bag_0.mcap"
    data = bytearray(file.read_bytes())
    data[1000:1010] = b"x" * 10
    file.write_bytes(data)
    assert run("recover --json bag") == 1
    document = json.loads(capsys.readouterr().out)
    assert document["path"] == "bag_recovered"
    assert 80 < document["messages"] < 100
    assert document["lost"][-1] == f"/topic_0: {100 - document['messages']} of 100 messages"
    assert run("check --json bag") == 1
    assert json.loads(capsys.readouterr().out)[0]["place"] == "bag/bag_0.mcap"


def test_reindex_says_what_ros2_says(bag, capsys):
    (bag / "metadata.yaml").unlink()
    assert run("reindex bag") == 0
    assert capsys.readouterr().err == (
        "Beginning reindexing bag in directory: bag\nReindexing complete: 100 messages.\n"
    )
    assert (bag / "metadata.yaml").exists()
    assert run("reindex bag/bag_0.mcap") == 1
    assert capsys.readouterr().err == "teleopctl: Must specify a bag directory\n"
