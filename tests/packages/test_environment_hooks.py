"""Environment hooks: variables that packages set, from their sources and below a found prefix."""

import os
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from teleopctl import packages
from teleopctl.packages.environment_hooks import Operation, source_hooks
from teleopctl.packages.prefixes import include_prefix_of
from tests.packages.prefix import install, write

# As in rmf_demos_assets.
ASSETS = """
project(assets)
ament_environment_hooks("${CMAKE_CURRENT_SOURCE_DIR}/hooks/${PROJECT_NAME}.dsv.in")
install(DIRECTORY models DESTINATION share/${PROJECT_NAME})
"""


@pytest.fixture
def source(tmp_path, monkeypatch):
    """A package ``assets`` in a workspace, with the given script and hooks."""
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", str(tmp_path))
    monkeypatch.delenv("TELEOPCTL_HOOKS", raising=False)
    folder = tmp_path / "assets"

    def make(hooks, script=ASSETS, name="CMakeLists.txt"):
        write(folder / "package.xml", "<package><name>assets</name></package>")
        write(folder / name, script)
        write(folder / "models/crate/model.sdf", "<sdf/>")
        for file, text in hooks.items():
            write(folder / file, text)
        return folder

    return make


def applied(monkeypatch, variable: str, before: str | None = None) -> str | None:
    """The variable after the hooks, with the prefix of the package as ``PREFIX``."""
    if before is None:
        monkeypatch.delenv(variable, raising=False)
    else:
        monkeypatch.setenv(variable, before)
    packages.apply_source_hooks()
    prefix = str(packages.find_package("assets").prefix)
    after = os.environ.get(variable)
    return None if after is None else after.replace(prefix, "PREFIX").replace(os.pathsep, ":")


def test_a_description_puts_a_folder_below_the_prefix_in_front_of_a_path(source, monkeypatch):
    source({"hooks/assets.dsv.in": "prepend-non-duplicate;GZ_PATH;share/assets/models\n"})
    assert applied(monkeypatch, "GZ_PATH", "/old") == "PREFIX/share/assets/models:/old"
    path = Path(os.environ["GZ_PATH"].split(os.pathsep)[0])
    assert (path / "crate/model.sdf").is_file()


def test_processes_with_the_variable_of_their_parent_do_not_apply_them_again(source, monkeypatch):
    source({"hooks/assets.dsv.in": "append-non-duplicate;GZ_PATH;share\n"})
    assert applied(monkeypatch, "GZ_PATH", "/old") == "/old:PREFIX/share"
    assert applied(monkeypatch, "GZ_PATH", "/other") == "/other"


@pytest.mark.parametrize(
    ("line", "before", "after"),
    [
        ("prepend-non-duplicate;V;share", "", "PREFIX/share"),
        ("prepend-non-duplicate;V;@CMAKE_INSTALL_PREFIX@/share", "/a", "PREFIX/share:/a"),
        (
            "prepend-non-duplicate;V;share/@PROJECT_NAME@;lib",
            None,
            "PREFIX/lib:PREFIX/share/assets",
        ),
        ("prepend-non-duplicate;V;", None, "PREFIX"),
        ("prepend-non-duplicate;V;/opt/models", None, "/opt/models"),
        ("prepend-non-duplicate-if-exists;V;not_there", "/a", "/a"),
        ("append-non-duplicate;V;share", "/a:/b", "/a:/b:PREFIX/share"),
        ("set;V;fast", "slow", "fast"),
        ("set;V;share", None, "PREFIX/share"),
        ("set-if-unset;V;fast", "slow", "slow"),
        ("source;share/assets/hook/other.sh", None, None),
        ("nonsense;V;share", None, None),
        ("", None, None),
    ],
)
def test_operations_of_a_description(source, monkeypatch, line, before, after):
    source({"hooks/assets.dsv.in": f"{line}\n"})
    assert applied(monkeypatch, "V", before) == after


@pytest.mark.parametrize(
    ("line", "before", "after"),
    [
        # depthai_descriptions
        ('ament_prepend_unique_value V "$AMENT_CURRENT_PREFIX/share"', "/a", "PREFIX/share:/a"),
        ("ament_append_unique_value V ${AMENT_CURRENT_PREFIX}", "/a", "/a:PREFIX"),
        ("export V=1  # fast", None, "1"),
        ("export V=share", None, "share"),
        ("export V=$AMENT_CURRENT_PREFIX/share", None, "PREFIX/share"),
        ("export V=$OTHER/share", None, None),
        ("export V=$V:$COLCON_CURRENT_PREFIX/share", "/a", "/a:PREFIX/share"),
        ("rm -r $HOME", None, None),
        ("echo 'over several", None, None),
    ],
)
def test_known_lines_of_shell_scripts_are_read_and_nothing_is_executed(
    source, monkeypatch, line, before, after
):
    source({"hooks/set.sh.in": line}, 'ament_environment_hooks("hooks/set.sh.in")')
    assert applied(monkeypatch, "V", before) == after


def test_of_a_script_and_a_description_of_one_name_the_description_counts(source):
    folder = source(
        {"env/a.sh.in": "export V=script", "env/a.dsv.in": "set;V;description"},
        "ament_environment_hooks(env/a.sh.in)\nament_environment_hooks(env/a.dsv.in)\n",
    )
    assert source_hooks("assets", folder) == [Operation("set", "V", "description")]


def test_a_python_package_installs_its_hooks(source, monkeypatch):
    script = """
from setuptools import setup
setup(data_files=[("share/assets/hook", ["hook/models.dsv"])])
"""
    hooks = {"hook/models.dsv": "prepend-non-duplicate;GZ_PATH;share/assets/models"}
    source(hooks, script, "setup.py")
    assert applied(monkeypatch, "GZ_PATH") == "PREFIX/share/assets/models"


def test_a_prefix_that_is_found_by_a_path_sets_what_its_setup_would(tmp_path, monkeypatch):
    prefix = install(
        tmp_path / "install",
        "assets",
        {
            "share/assets/package.dsv": """\
                source;share/assets/hook/models.sh
                source;share/assets/hook/models.dsv
                source;share/assets/package.dsv
                prepend-non-duplicate;PYTHONPATH;lib/python3.12/site-packages
                """,
            "share/assets/hook/models.dsv": "prepend-non-duplicate;GZ_PATH;share/assets/models",
            "share/assets/launch/up.yaml": "",
        },
    )
    monkeypatch.setenv("AMENT_PREFIX_PATH", "")
    monkeypatch.setenv("PYTHONPATH", "/mine")
    monkeypatch.setenv("GZ_PATH", "")
    include_prefix_of(prefix / "share/assets/launch/up.yaml")
    assert os.environ["GZ_PATH"] == str(prefix / "share/assets/models")
    assert os.environ["PYTHONPATH"] == "/mine"  # modules of a prefix are found without


@given(st.text())
def test_no_text_of_a_hook_makes_the_reader_fail(tmp_path_factory, text):
    folder = tmp_path_factory.mktemp("hooks")
    (folder / "CMakeLists.txt").write_text("ament_environment_hooks(a.dsv b.sh)")
    for name in ("a.dsv", "b.sh"):
        (folder / name).write_bytes(text.encode("utf-8", "surrogatepass"))
    for operation in source_hooks("assets", folder):
        operation.apply(folder, dict(os.environ))
        assert operation.variable.isidentifier()
