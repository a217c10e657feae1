"""The documentation says what is true: links, command lines, launch files, pictures."""

import ast
import re
import shlex
from collections.abc import Iterator

import pytest
import typer

from teleopctl.cli.typer_app import command_tree
from teleopctl.cli.typer_line import typer_line
from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.frontends import read_launch_file
from teleopctl.packages import NewPackage, create_package
from tests import ROOT, ros2_table

README = ROOT / "README.md"
PAGES = [README, *sorted((ROOT / "docs").rglob("*.md"))]

# Pages whose commands tests/system/test_pages.py types in their order, as a reader would.
TYPED = {
    page: ROOT / f"{'' if page == 'README' else 'docs/'}{page}.md"
    for page in (
        *("README", "bag", "cheat_sheet", "foxglove", "from_ros2", "json", "launch_files", "nodes"),
        *("episodes", "page", "ros2", "simulation", "ten_words", "terminal", "tutorial"),
        *("kinematics", "launch_tests", "sensors", "servo", "stop", "worlds"),
    )
}

# What runs the commands of the other pages.
ELSEWHERE = {
    "components": "tests/system/test_components.py",
    "first_tutorials": "tests/system/test_turtlesim.py",
    "doctor": "tests/system/test_doctor.py",
    "drive": "tests/system/test_drive.py",
    "moveit": "tests/system/test_move_group.py",
    "own_robot": "tests/system/test_own_robot.py",
    "sweep": "tests/sweep/test_sweep.py",
    "rclpy_tests": "tests/compat/test_rclpy_published.py",
    **{path.stem: "tests/test_extending.py" for path in PAGES if path.parent.name == "extending"},
}

LARGEST_PICTURE_BYTES = 300_000

BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[[^]]*\]\(([^)\s]+)\)")
INLINE = re.compile(r"`teleopctl ([^`]+)`")
FILE_NAME = re.compile(r"^(?:# |<!-- )(\S+/\S+?)(?: -->)?\n")

page = pytest.mark.parametrize("page", PAGES, ids=lambda path: f"{path.parent.name}/{path.name}")


def text_of(path):
    return path.read_text(encoding="utf-8")


def blocks(path, *languages):
    return [text for language, text in BLOCK.findall(text_of(path)) if language in languages]


def prose(path):
    return BLOCK.sub("", text_of(path))


def anchors(path):
    """The anchors of a page's headings, as GitHub makes them."""
    titles = re.findall(r"^#+ (.+)$", prose(path), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def command_lines(path):
    """What a reader would type: all of ``sh`` blocks, the prompts of ``console`` blocks."""
    for text in blocks(path, "sh"):
        yield from whole_lines(text.splitlines(), prompt="")
    for text in blocks(path, "console"):
        yield from whole_lines(text.splitlines(), prompt="$ ")


def whole_lines(lines, prompt) -> Iterator[str]:
    """Join lines that a backslash or an open quote continues."""
    waiting = ""
    for line in lines:
        if not waiting and not line.startswith(prompt):
            continue
        waiting += line if waiting else line.removeprefix(prompt)
        if waiting.endswith("\\"):
            waiting = waiting[:-1]
            continue
        try:
            shlex.split(waiting, comments=True)
        except ValueError:
            waiting += "\n"
            continue
        yield waiting
        waiting = ""
    assert not waiting, f"never ends: {waiting}"


def calls(line):
    """The words behind each ``teleopctl`` of a command line."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars=True)
    lexer.whitespace_split = True
    command: list[str] = []
    for word in [*lexer, ";"]:
        if set(word) <= set("();<>|&"):
            if command[:1] == ["teleopctl"]:
                yield command[1:]
            command = []
        else:
            command.append(word)


def command_named(words):
    """The command that the first words name, and the words that are left for it."""
    tree = command_tree(words)
    assert words[0] in tree.commands, f"there is no verb {words[0]}"
    command, rest = tree.commands[words[0]], words[1:]
    subcommands = getattr(command, "commands", None)
    if subcommands and rest:
        assert rest[0] in subcommands, f"there is no verb {words[0]} {rest[0]}"
        command, rest = subcommands[rest[0]], rest[1:]
    return command, rest


def check(words):
    if words[0].startswith("-"):
        return
    # As the program reads it: lists of values, and options that may stand without theirs.
    command, rest = command_named(typer_line(command_tree(words), words))
    try:
        command.make_context(words[0], list(rest))
    except typer.TyperException as wrong:
        pytest.fail(f"teleopctl {shlex.join(words)}: {wrong.format_message()}")


@page
def test_every_relative_link_leads_somewhere(page):
    for target in LINK.findall(prose(page)):
        if "://" in target:
            continue
        name, _, anchor = target.partition("#")
        file = page.parent / name if name else page
        assert file.exists(), f"{page.name} links to {target}"
        if anchor:
            assert anchor in anchors(file), f"{page.name} links to {target}"


def test_every_page_is_reached_from_the_readme():
    reached, waiting = {README}, [README]
    while waiting:
        page = waiting.pop()
        linked = {(page.parent / target).resolve() for target in LINK.findall(text_of(page))}
        waiting += (linked & set(PAGES)) - reached
        reached |= linked
    assert set(PAGES) <= reached


@page
def test_every_command_line_is_one_that_the_program_understands(page):
    for line in command_lines(page):
        for words in calls(line):
            check(words)


@page
def test_every_verb_named_in_the_text_exists(page):
    for line in INLINE.findall(prose(page)):
        words = line.split()
        if words[0][0].isalpha():
            command_named([word for word in words if word[0].isalpha()])


def test_the_commands_of_every_page_are_run_by_a_test():
    with_commands = {page.stem for page in PAGES if list(command_lines(page))}
    assert with_commands <= TYPED.keys() | ELSEWHERE.keys()
    assert not TYPED.keys() & ELSEWHERE.keys()
    assert all((ROOT / test).exists() for test in ELSEWHERE.values())


def test_a_misspelled_option_would_be_noticed():
    (words,) = calls("teleopctl topic echo --onse /chatter > file &")
    with pytest.raises(pytest.fail.Exception, match="--onse"):
        check(words)


def test_the_launch_files_of_the_nodes_page_plan_the_processes_that_it_shows(tmp_path, monkeypatch):
    for text in blocks(ROOT / "docs" / "nodes.md", "xml", "yaml", "python"):
        name = FILE_NAME.match(text)
        if name:
            file = tmp_path / name[1]
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    made = NewPackage("greeter", "ament_python", 3, "", "", "", "", node_name="talker")
    create_package(made, str(tmp_path / "made"), lambda _: None)
    for file in ("package.xml", "setup.py"):
        (tmp_path / "made/greeter" / file).rename(tmp_path / "greeter" / file)
    launch_files = [*tmp_path.rglob("launch/*.yaml"), *tmp_path.rglob("launch/*.xml")]
    assert len(launch_files) == 2
    plans = []
    for file in launch_files:
        plan, _ = evaluate(
            read_launch_file(file), {"who": "Ada", "twice": "true"}, tmp_path / "log"
        )
        assert [process.name for process in plan.processes] == [
            "talker-1",
            "talker-2",
            "simple_subscriber-3",
        ]
        assert not plan.warnings
        plans.append(plan)
    assert plans[0] == plans[1]


def test_pictures_are_small_enough_for_a_first_screen():
    pictures = list((ROOT / "docs" / "images").glob("*.png"))
    assert {picture.stem for picture in pictures} >= {"teleop_arm", "camera"}
    assert all(picture.stat().st_size <= LARGEST_PICTURE_BYTES for picture in pictures)


def reference_pages():
    """The modules to which the site has a page of the API: front doors, and those that it lists."""
    names = text_of(ROOT / "tests" / "public_names.txt").split()
    (listed,) = (
        ast.literal_eval(statement.value)
        for statement in ast.parse(text_of(ROOT / ".ci" / "reference.py")).body
        if isinstance(statement, ast.Assign) and ast.unparse(statement.targets[0]) == "MODULES"
    )
    return {name.rpartition(".")[0] for name in names} | {f"teleopctl.{name}" for name in listed}


def test_the_reference_has_a_page_of_every_module_that_the_documentation_uses():
    used = {"teleopctl.errors", "teleopctl.plugins"}  # the pages name them in prose
    for path in PAGES:
        for text in blocks(path, "python"):
            for module, names in re.findall(
                r"^ *from (teleopctl\.[\w.]+) import (.+)$", text, re.M
            ):
                parts = [f"{module}.{name.strip()}" for name in names.split(",")]
                used.update(parts if module == "teleopctl.cli" else [module])
    assert used >= {"teleopctl.cli.verb", "teleopctl.cli.console", "teleopctl.control"}
    assert used <= reference_pages()


def test_the_page_on_ros2s_verbs_is_what_the_declarations_make():
    same = ros2_table.PAGE.read_text(encoding="utf-8") == ros2_table.page()
    assert same, "run `python -m tests.ros2_table`, and look at what it changes"
