"""Bags that are damaged by chance, and in the ways that chance has found: no verb fails by them."""

from __future__ import annotations

import contextlib
import random
import sqlite3

import pytest

from teleopctl.bag import check, open_bag, recover
from teleopctl.bag.metadata import METADATA_FILE, parse_metadata
from teleopctl.errors import InvalidFileError
from tests.bag.bags import write_bag
from tests.bag.test_sqlite_reader import write_database
from tests.fuzz.bags import make_bags, trials
from tests.samples import is_nightly, sample


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    return make_bags(tmp_path_factory.mktemp("whole"))


@pytest.mark.parametrize("kind", sample(["db3", "mcap", "metadata", "packed"], 2))
def test_no_verb_fails_by_what_stands_in_a_bag(bags, tmp_path, monkeypatch, kind):
    monkeypatch.chdir(tmp_path)
    for seed in range(25 if is_nightly() else 10):
        for trial in trials(random.Random(seed), kind, bags[kind], tmp_path):
            assert not trial.is_defect, (seed, trial.words, trial.written)


@pytest.mark.parametrize(
    "value", ["!!int ''", "!!float ''", "!!timestamp x", "!!bool x", ".inf", "1e400", "[]", "'x'"]
)
def test_numbers_of_metadata_that_are_none_are_refused(tmp_path, value):
    write_bag(tmp_path / "bag", count=3)
    text = (tmp_path / "bag" / METADATA_FILE).read_text("utf-8")
    with pytest.raises(InvalidFileError):
        parse_metadata(text.replace("message_count: 3", f"message_count: {value}"))
    (tmp_path / "bag" / METADATA_FILE).write_text(
        text.replace("message_count: 3", f"message_count: {value}"), "utf-8"
    )
    with open_bag(tmp_path / "bag") as bag:
        assert len(list(bag.messages())) == 3


def changed(file, *statements):
    with contextlib.closing(sqlite3.connect(file)) as database, database:
        for statement in statements:
            database.execute(statement)


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE messages SET timestamp = -5 WHERE id % 4 = 0",
        "UPDATE messages SET timestamp = 'soon' WHERE id % 4 = 0",
        "UPDATE messages SET timestamp = 1.5e300 WHERE id % 4 = 0",
        "UPDATE messages SET data = CAST(x'ff00fe' AS TEXT) WHERE id % 4 = 0",
        "UPDATE messages SET topic_id = 'x' WHERE id % 4 = 0",
    ],
)
def test_rows_that_are_no_messages_are_counted_and_the_others_are_read(tmp_path, change):
    write_database(tmp_path / "x.db3", count=40)
    changed(tmp_path / "x.db3", change)
    findings = [what for _, what in check(tmp_path / "x.db3")]
    assert any("10 rows of its messages are invalid" in what for what in findings)
    recovery = recover(tmp_path / "x.db3", tmp_path / "out")
    assert recovery.message_count == 30
    with open_bag(tmp_path / "x.db3") as bag:
        assert bag.metadata.message_count == len(list(bag.messages())) == 30
        assert bag.latest("/x", 2**62)


@pytest.mark.parametrize("column", ["id", "name", "type"])
def test_a_database_whose_topics_lack_a_column_is_refused_with_the_file(tmp_path, column):
    write_database(tmp_path / "x.db3", count=3)
    changed(tmp_path / "x.db3", f"ALTER TABLE topics RENAME COLUMN {column} TO other")
    with pytest.raises(InvalidFileError, match=r"x\.db3: (its topics have no|no such column)"):
        open_bag(tmp_path / "x.db3")


def test_a_column_whose_name_is_no_text_is_no_defect(tmp_path):
    write_database(tmp_path / "x.db3", count=30)
    file = tmp_path / "x.db3"
    file.write_bytes(file.read_bytes().replace(b"qos_profiles", b"qos_pr\xff\xfeles"))
    with contextlib.suppress(InvalidFileError):
        list(check(tmp_path / "x.db3"))
    with contextlib.suppress(InvalidFileError):
        recover(tmp_path / "x.db3", tmp_path / "out")
