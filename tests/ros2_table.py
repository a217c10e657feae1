"""Generator of the page on ros2's verbs and flags, from `ros2_flags` and teleopctl's declarations.

``python -m tests.ros2_table`` writes the page and prints how many verbs and flags teleopctl has;
`tests.test_docs` checks that the page is up to date.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from teleopctl import plugins
from teleopctl.cli import ros2_options
from teleopctl.cli.verb import Option, Verb, VerbGroup, parameters
from tests import ROOT
from tests.ros2_flags import ELSEWHERE, FLAGS, NOT_HERE, OTHER_TEXTS, OTHERWISE

PAGE = ROOT / "docs/ros2_verbs.md"

_HEAD = """\
# Every verb and flag of ros2

Look up a verb of `ros2` and its flags, and whether they are here. Based on Jazzy, with Lyrical's
additions.
`python -m tests.ros2_table` makes this page from the verbs' declarations.

| column | content |
|---|---|
| same | ROS 2's flags that are here, with the same name and meaning |
| additional | flags that only teleopctl has |
| not here | ROS 2's flags that are missing, with the reason |
| differences | other differences |

Accepted without effect, and not listed: `--spin-time`, `--no-daemon`, and `--use-sim-time` on verbs
that read no time. Every verb has `--help`. [From ROS 2](from_ros2.md#the-command-line) has
differences of all verbs, such as the exit status.
"""
_COLUMNS = "| verb | same | additional | not here | differences |\n|---|---|---|---|---|"


class Row:
    """Row of the table: comparison of one verb of ros2 with teleopctl's verb.

    Args:
        name: Name of the verb, such as ``topic list``.
        theirs: Alternative names of each flag of ros2's verb.
    """

    def __init__(self, name: str, theirs: list[list[str]]) -> None:
        self.name = name
        self.group = name.partition(" ")[0]
        declared = declared_flags(ELSEWHERE.get(name, name))
        self.is_here = declared is not None
        self.same: list[str] = []
        self.missing: list[str] = []
        self.count = len(theirs)
        self.count_here = 0
        besides = dict.fromkeys(declared or ())
        for flags in theirs if self.is_here else ():
            # A name of ros2's flag may be a flag of another meaning in teleopctl: `launch -d`.
            ours = max(declared or (), key=lambda each: _overlap(each, flags), default=())
            here = [flag for flag in flags if flag in ours]
            self.missing += [f for f in flags if f not in here and not _is_accepted(name, f)]
            if here:
                self.same.append("/".join(here))
                besides.pop(ours, None)
            self.count_here += bool(here) or any(_is_accepted(name, flag) for flag in flags)
        self.besides = ["/".join(flags) for flags in besides]

    def reasons(self) -> dict[str, str]:
        """Return the reason for each missing flag, or for the missing verb; "" without a reason."""
        if not self.is_here:
            return {self.name: NOT_HERE.get(self.name) or NOT_HERE.get(self.group, "")}
        return {
            flag: NOT_HERE.get(f"{self.name} {flag}") or NOT_HERE.get(f"{self.group} {flag}", "")
            for flag in self.missing
        }

    def line(self) -> str:
        """Return the row as Markdown."""
        by_reason: dict[str, list[str]] = {}
        for name, reason in self.reasons().items():
            by_reason.setdefault(reason, []).append(name)
        missing = "; ".join(
            f"{_code(names) if self.is_here else 'the verb'}: {reason}"
            for reason, names in by_reason.items()
        )
        keys = (self.name,) if self.group in FLAGS else (self.group, self.name)
        otherwise = [OTHERWISE[key] for key in keys if key in OTHERWISE]
        cells = (
            f"`{self.name}`",
            _code(self.same),
            _code(self.besides),
            missing,
            "; ".join(otherwise),
        )
        return f"| {' | '.join(cells)} |".replace("|  |", "| |").replace("|  |", "| |")


def rows() -> list[Row]:
    """Return a row for each verb of ros2."""
    return [Row(name, [one.split("/") for one in text.split()]) for name, text in FLAGS.items()]


def page() -> str:
    """Return the text of the page."""
    found = rows()
    lines = [_HEAD]
    for group, members in _by_group(found):
        lines += [f"## {group}", "", _COLUMNS, *(row.line() for row in members), ""]
    lines += [
        "## Printed text",
        "",
        "What a verb prints on stdout is ROS 2's text, character for character. Two hundred texts",
        "are compared (`tests/system/test_ros2_texts.py`, `test_control_texts.py`,",
        "`ros2_refusals.py`). These deviate:",
        "",
        "| verb | ROS 2 prints | teleopctl prints | reason |",
        "|---|---|---|---|",
        *(
            f"| {verb if verb == 'every verb' else f'`{verb}`'} | {theirs} | {ours} | {reason} |"
            for verb, theirs, ours, reason in OTHER_TEXTS
        ),
        "",
        "## Ours alone",
        "",
        ", ".join(f"`{name}`" for name in ours_alone(row.name for row in found)) + ".",
        "",
    ]
    return "\n".join(lines)


def ours_alone(theirs: Iterable[str]) -> list[str]:
    """Return teleopctl's verbs that ros2 does not have; the group if ros2 lacks all its verbs."""
    known = {ELSEWHERE.get(name, name) for name in theirs}
    groups = {name.partition(" ")[0] for name in known}
    found = []
    for name in plugins.VERBS.builtin:
        verb: Verb | VerbGroup = plugins.load(plugins.VERBS, name)
        if name not in groups:
            found.append(name)
        elif isinstance(verb, VerbGroup):
            found += [f"{name} {inner}" for inner in verb.verbs if f"{name} {inner}" not in known]
    return found


def declared_flags(name: str) -> list[tuple[str, ...]] | None:
    """Return the flags of a verb of teleopctl; None if the verb does not exist."""
    first, _, second = name.partition(" ")
    if first not in plugins.VERBS.builtin:
        return None
    verb: Verb | VerbGroup | None = plugins.load(plugins.VERBS, first)
    if isinstance(verb, VerbGroup):
        verb = verb.verbs.get(second)
    if verb is None:
        return None
    declarations = (each.declaration for each in parameters(verb.load()))
    return [tuple(each.flags) for each in declarations if isinstance(each, Option)]


def _overlap(ours: tuple[str, ...], theirs: list[str]) -> int:
    """Return the total length of the names that two flags share; long names count more."""
    return sum(len(flag) for flag in theirs if flag in ours)


def _is_accepted(name: str, flag: str) -> bool:
    """Return whether a flag is accepted without effect."""
    return flag not in ros2_options.without_ignored_options([*name.split(), flag, "1"])


def _by_group(found: list[Row]) -> Iterator[tuple[str, list[Row]]]:
    groups: dict[str, list[Row]] = {}
    for row in found:
        groups.setdefault(row.group, []).append(row)
    yield from sorted(groups.items())


def _code(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def counts() -> str:
    """Return the number of ros2's verbs and flags that teleopctl has, as text."""
    found = rows()
    verbs = f"{sum(row.is_here for row in found)} of {len(found)} verbs"
    return f"{verbs}, {sum(row.count_here for row in found)} of {sum(r.count for r in found)} flags"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(counts())
