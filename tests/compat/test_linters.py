"""ament_flake8 and so on: what the tests of ament packages call."""

import importlib.util
import shutil

import pytest
from ament_copyright.main import main as copyright_main
from ament_flake8.main import main as flake8, main_with_errors
from ament_pep257.main import main as pep257
from ament_xmllint.main import main as xmllint

from teleopctl.errors import UnavailableError

GOOD = '"""A module."""\n\n\ndef main():\n    """Say hello."""\n    print("hello")\n'


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "good.py").write_text(GOOD)
    return tmp_path


def test_good_code_passes(capsys):
    assert main_with_errors(argv=[]) == (0, [])
    assert pep257(argv=[".", "test"]) == 0
    assert capsys.readouterr().out == "\nNo problems found\nNo problems found\n"


def test_problems_are_listed_as_flake8_lists_them(folder, capsys):
    (folder / "bad.py").write_text("import os\nx = 1\ndef f():\n    return lambda: 0 \n")
    assert main_with_errors(argv=["."]) == (
        1,
        [
            "bad.py:1:8: F401 `os` imported but unused",
            "bad.py:3:1: E302 Expected 2 blank lines, found 0",
            "bad.py:4:21: W291 Trailing whitespace",
        ],
    )
    assert "3 errors\n'E'-type errors: 1\n" in capsys.readouterr().out
    (folder / "AMENT_IGNORE").touch()
    assert flake8(argv=["."]) == 0


def test_what_flake8_allows_is_allowed(folder):
    (folder / "allowed.py").write_text(
        f'"""A module."""\n\npredicate = (lambda: 1)\nlong = "{"x" * 90}"\n'
    )
    assert flake8(argv=[]) == 0
    assert flake8(argv=["--linelength", "80"]) == 1
    assert flake8(argv=["--exclude", "allowed.py", "--linelength", "80"]) == 0


def test_docstrings_follow_the_convention_of_ament(folder, capsys):
    (folder / "bad.py").write_text('def f():\n    """no capital and no period"""\n')
    assert pep257(argv=["."]) == 1
    assert "bad.py:2:5: D400" in capsys.readouterr().err
    assert pep257(argv=[".", "--add-ignore", "D4"]) == 0


def test_xml_files_are_well_formed(folder, capsys):
    assert xmllint(argv=[]) == 1
    (folder / "package.xml").write_text("<package/>")
    assert xmllint(argv=[]) == 0
    (folder / "bad.xml").write_text("<package>")
    assert xmllint(argv=[]) == 1
    assert "File 'bad.xml' is invalid" in capsys.readouterr().err


def test_what_cannot_be_checked_is_skipped_with_the_reason(monkeypatch):
    with pytest.raises(pytest.skip.Exception, match="copyright headers are not checked here"):
        copyright_main(argv=["."])
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    monkeypatch.setattr(shutil, "which", lambda _: None)
    with pytest.raises(pytest.skip.Exception, match=r"pip install 'teleopctl\[lint\]'"):
        flake8(argv=[])
    monkeypatch.delenv("PYTEST_CURRENT_TEST")
    with pytest.raises(UnavailableError):
        copyright_main()
