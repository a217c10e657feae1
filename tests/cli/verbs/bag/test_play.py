"""What the words of ``bag play`` and ``bag burst`` mean to the player."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from teleopctl.bag import PlayOptions, PlaySelection
from teleopctl.cli import main
from teleopctl.cli.verbs.bag import playing
from teleopctl.node import QoSProfile, ReliabilityPolicy
from tests.bag.bags import write_bag

SECOND = 10**9


@pytest.fixture
def asked(monkeypatch, tmp_path):
    """Runs a command line; returns what the player was asked for, without playing."""
    monkeypatch.chdir(tmp_path)
    write_bag(tmp_path / "bag", count=1)
    calls: list[Any] = []  # Any: the arguments of the function

    def remember(*arguments: Any, **named: Any) -> int:
        calls.append((*arguments, named))
        return 0

    monkeypatch.setattr(playing, "play_bags", remember)

    def run(line: str) -> Any:
        calls.clear()
        assert main.run(["bag", *line.split()]) == 0
        return calls[0]

    return run


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("", {}),
        ("-r 2.5 -l -d 0.5 -p", {"rate": 2.5, "loop": True, "delay_s": 0.5, "is_paused": True}),
        ("--start-offset 1.5", {"start_offset_ns": 1_500_000_000}),
        ("--playback-duration 0", {"duration_ns": 0}),
        ("--playback-duration=-1", {}),
        ("--playback-until-sec 12.5", {"until_ns": 12_500_000_000}),
        ("--playback-until-nsec 1700000000000000001", {"until_ns": 1_700_000_000_000_000_001}),
        ("--topics a /b --loop", {"selection": PlaySelection(topics=("a", "/b")), "loop": True}),
        ("--services s --actions t", {"selection": PlaySelection(services=("s",), actions=("t",))}),
        ("-e /x.* -x .*y", {"selection": PlaySelection(regex="/x.*", exclude_regex=".*y")}),
        (
            "--exclude-topics a --exclude-services b c --exclude-actions d",
            {
                "selection": PlaySelection(
                    exclude_topics=("a",), exclude_services=("b", "c"), exclude_actions=("d",)
                )
            },
        ),
        ("--clock", {"clock_hz": 40.0}),
        ("--clock --loop", {"clock_hz": 40.0, "loop": True}),
        ("--clock 100", {"clock_hz": 100.0}),
        ("--clock=5", {"clock_hz": 5.0}),
        ("--clock-topics /a /b", {"clock_topics": ("/a", "/b")}),
        ("--clock-topics-all", {"clock_topics": None}),
        ("--read-ahead-queue-size 7", {"read_ahead": 7}),
        ("--message-order sent", {"message_order": "sent"}),
        (
            "--publish-service-requests --service-requests-source client_introspection",
            {"publishes_requests": True, "request_source": "client_introspection"},
        ),
        ("--send-actions-as-client", {"sends_actions": True}),
        ("--wait-for-all-acked 100", {"is_lossless": True}),
        ("--disable-loan-message", {}),
    ],
)
def test_the_words_of_play_are_the_players_options(asked, words, expected):
    bags, options, remaps, terminal, _ = asked(f"play bag {words}")
    assert bags == [(Path("bag"), None)]
    assert options == PlayOptions(**expected)
    assert remaps == []
    assert terminal == playing.Terminal(True, 3, 2, "info")


def test_several_bags_are_given_each_with_its_storage(asked):
    assert asked("play -i one mcap -i two -i three sqlite3")[0] == [
        (Path("one"), "mcap"),
        (Path("two"), None),
        (Path("three"), "sqlite3"),
    ]
    assert asked("play bag -s mcap")[0] == [(Path("bag"), "mcap")]


def test_remaps_and_what_is_shown_go_to_the_node_and_the_terminal(asked):
    _, _, remaps, terminal, _ = asked(
        "play bag -m /a:=/b c:=d --disable-keyboard-controls --progress-bar-update-rate 10"
        " --progress-bar-separation-lines 0 --log-level warn"
    )
    assert remaps == ["/a:=/b", "c:=d"]
    assert terminal == playing.Terminal(False, 10, 0, "warn")


def test_burst_sends_at_once_and_pauses(asked):
    bags, options, remaps, _, named = asked(
        "burst bag -n 5 --topics /a --start-offset 2 -m /a:=/b --read-ahead-queue-size 3"
    )
    assert bags == [(Path("bag"), None)]
    assert options == PlayOptions(
        is_paused=True,
        is_lossless=True,
        start_offset_ns=2 * SECOND,
        selection=PlaySelection(topics=("/a",)),
        read_ahead=3,
    )
    assert remaps == ["/a:=/b"]
    assert named == {"burst": 5}


def test_quality_of_service_is_read_from_a_file(asked, tmp_path):
    (tmp_path / "qos.yaml").write_text(
        "/a:\n  reliability: best_effort\n  depth: 3\n  deadline: {sec: 1, nsec: 5}\n"
    )
    profile = asked("play bag --qos-profile-overrides-path qos.yaml")[1].qos_overrides["/a"]
    assert isinstance(profile, QoSProfile)
    assert (profile.reliability, profile.depth) == (ReliabilityPolicy.BEST_EFFORT, 3)
    assert profile.deadline.nanoseconds == SECOND + 5


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[1]", "does not map topics to profiles"),
        ("/a: 3", "/a is no profile"),
        ("/a: {reliability: maybe}", "/a: 'maybe' is no ReliabilityPolicy"),
        ("/a: {history: keep_last}", "/a: History set to KEEP_LAST without a depth"),
        ("/a: {depth: -1}", "/a: `depth` may not be a negative value."),
        ("/a: {deadline: {sec: 1}}", "must include both seconds (sec) and nanoseconds (nsec)"),
        ("/a: {deadline: {sec: -1, nsec: 0}}", "may not be a negative value"),
        ("/a: {speed: 1}", "Unexpected key `speed` for QoS profile."),
        ("a: b: c", ":1: not YAML: mapping values are not allowed"),
    ],
)
def test_what_is_no_profile_is_told_with_its_topic(asked, tmp_path, capsys, text, said):
    (tmp_path / "qos.yaml").write_text(text)
    assert main.run(["bag", "play", "bag", "--qos-profile-overrides-path", "qos.yaml"]) == 1
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("play", "no input bags were provided"),
        ("play bag -i bag", "do not mix the [bag_path] positional argument"),
        ("play bag --rate 0", "--rate 0 is not in the valid range (> 0.0)"),
        ("play bag --clock=-1", "--clock -1 is not in the valid range (> 0.0)"),
        ("play bag --delay=-1", "--delay -1 is not in the valid range (>= 0.0)"),
        ("play bag --start-offset=-1", "--start-offset -1: Value is less than zero."),
        ("play bag --clock --clock-topics-all", "--clock and --clock-topics-all exclude"),
        (
            "play bag --playback-until-sec 1 --playback-until-nsec 1",
            "--playback-until-sec and --playback-until-nsec exclude each other",
        ),
        ("play bag --regex (", "'(' is not a regular expression"),
        ("play bag --read-ahead-queue-size 0", "read_ahead_queue_size must be at least 1"),
        ("play bag --storage-config-file none", "there is no file none"),
        ("burst bag --num-messages=-1", "Value is less than zero"),
        ("burst", "Missing argument 'BAG'"),
    ],
)
def test_what_cannot_be_meant_is_told(asked, capsys, line, said):
    assert main.run(["bag", *line.split()]) == 2
    assert said in capsys.readouterr().err
