"""Files of a source package that ``data_files`` installs elsewhere than they lie."""

import os
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from teleopctl import packages
from teleopctl.launch import find_launch_file
from teleopctl.packages.finding import _packages_below
from teleopctl.packages.installed_layout import prefix_folder, share_folder
from teleopctl.packages.setup_script import setup_arguments

PREAMBLE = """
import os
from glob import glob
from os.path import join
from setuptools import find_packages, setup
package_name = "arm"
SHARE = os.path.join("share", package_name)
"""


@pytest.fixture
def arm(tmp_path, monkeypatch):
    """A package ``arm`` with files to install, found from the working directory."""
    for file in ("bringup/up.launch.yaml", "config/a.yaml", "config/b.yaml", "cad/a.stl"):
        path = tmp_path / "src/arm" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"# {file}")
    folder = tmp_path / "src/arm"
    (folder / "package.xml").write_text("<package><name>arm</name></package>")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TELEOPCTL_RUNTIME_DIR", str(tmp_path / "run"))
    yield folder
    forget()


def forget():
    """What a command reads once is read again, as by the next command."""
    _packages_below.cache_clear()
    share_folder.cache_clear()


def install(folder: Path, data_files: str, before: str = "") -> Path:
    text = f"{PREAMBLE}{before}\nsetup(name=package_name, data_files={data_files})\n"
    text += "raise SystemExit('read, never executed')\n"
    (folder / "setup.py").write_text(text)
    forget()
    return packages.package_share("arm")


def files_of(share: Path) -> dict[str, str]:
    """What a share folder holds: path → the source file's, followed through links."""
    found = {}
    for root, _, files in os.walk(share, followlinks=True):
        for file in files:
            path = Path(root, file)
            source = path.resolve().relative_to(Path.cwd() / "src/arm")
            found[path.relative_to(share).as_posix()] = source.as_posix()
    return found


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize(
    ("data_files", "before"),
    [
        ("[('share/arm/launch', ['bringup/up.launch.yaml'])]", ""),
        ("[(os.path.join('share', package_name, 'launch'), glob('bringup/*.launch.*'))]", ""),
        ("[(f'share/{package_name}/launch/', glob(os.path.join('bringup', '*')))]", ""),
        ("[('share/' + package_name + '/launch', glob('bringup/**', recursive=True))]", ""),
        ("[('share/%s/launch' % package_name, [f for f in glob('*/*') if 'up' in f])]", ""),
        ("files", "files = []\nfiles.append((join(SHARE, 'launch'), glob('bringup/*.yaml')))"),
        ("[*own, (SHARE, unknown)]", "own = [(SHARE + '/launch', ['bringup/up.launch.yaml'])]"),
        (
            "found('bringup', 'launch')",
            "def found(top, to='x'):\n"
            "    result = []\n"
            "    for path, _, names in os.walk(top):\n"
            "        files = [os.path.join(path, name) for name in names]\n"
            "        result += [(os.path.join(SHARE, to), files)]\n"
            "    return result",
        ),
        (
            "[(SHARE + '/launch', launches)]",
            "launches = []\n"
            "for root, dirs, files in os.walk('.'):\n"
            "    for file in files:\n"
            "        if file.endswith('.launch.yaml'):\n"
            "            launches.append(os.path.join(root, file))",
        ),
    ],
)
def test_a_file_is_where_setup_py_installs_it(arm, data_files, before):
    share = install(arm, data_files, before)
    source = arm / "bringup/up.launch.yaml"
    assert (share / "launch/up.launch.yaml").resolve() == source
    assert packages.resolve_uri("package://arm/launch/up.launch.yaml").resolve() == source
    assert find_launch_file("arm", "up.launch.yaml") == share / "launch/up.launch.yaml"
    assert files_of(share) == {
        "bringup/up.launch.yaml": "bringup/up.launch.yaml",
        "cad/a.stl": "cad/a.stl",
        "config/a.yaml": "config/a.yaml",
        "config/b.yaml": "config/b.yaml",
        "launch/up.launch.yaml": "bringup/up.launch.yaml",
        "package.xml": "package.xml",
        "setup.py": "setup.py",
    }


def test_what_is_installed_hides_a_source_file_of_its_place_and_no_other(arm):
    share = install(arm, "[('share/arm/config', ['cad/a.stl']), (SHARE, ['config/a.yaml'])]")
    found = files_of(share)
    assert found["config/a.stl"] == "cad/a.stl"
    assert found["a.yaml"] == found["config/a.yaml"] == "config/a.yaml"
    assert found["config/b.yaml"] == "config/b.yaml"
    (arm / "other").mkdir()
    (arm / "other/b.yaml").touch()
    assert files_of(install(arm, "[(SHARE + '/config', glob('other/*'))]")) == {
        **{f: f for f in ("bringup/up.launch.yaml", "cad/a.stl", "config/a.yaml", "package.xml")},
        "setup.py": "setup.py",
        "config/b.yaml": "other/b.yaml",
        "other/b.yaml": "other/b.yaml",
    }


@pytest.mark.parametrize(
    "data_files",
    [
        "[('share/arm/config', glob('config/*')), ('share/arm', ['package.xml'])]",
        "[('share/ament_index/resource_index/packages', ['config/a.yaml']), ('lib/arm', ['x'])]",
        "[('share/arm/../../etc', ['config/a.yaml']), ('/etc', ['config/a.yaml'])]",
        "[('share/arm/launch', ['not/there.yaml', 'bringup']), 'config/a.yaml', 3]",
        "__import__('os').listdir('/')",
    ],
)
def test_a_package_whose_files_stay_in_place_is_used_where_it_lies(arm, data_files):
    assert install(arm, data_files) == arm
    assert not Path("run").exists()


def test_the_layout_follows_the_sources(arm):
    data_files = "[(SHARE + '/settings', glob('config/*.yaml'))]"
    share = install(arm, data_files)
    before = (share / "settings/a.yaml").lstat().st_mtime_ns
    (arm / "config/c.yaml").touch()
    (arm / "config/b.yaml").unlink()
    assert install(arm, data_files) == share
    assert names(share / "settings") == ["a.yaml", "c.yaml"]
    assert (share / "settings/a.yaml").lstat().st_mtime_ns == before
    install(arm, "[(SHARE + '/bringup', glob('config/c*'))]")
    assert names(share / "bringup") == ["c.yaml", "up.launch.yaml"]
    assert not (share / "settings").exists()
    install(arm, "[(SHARE + '/settings', glob('config/a*'))]")
    assert (share / "bringup").is_symlink()


def test_a_console_script_is_found_without_a_look_at_the_files(arm, monkeypatch):
    monkeypatch.setattr("glob.iglob", None)
    text = PREAMBLE + "files = glob('*')\nsetup(data_files=files, entry_points={'a': ['b']})"
    assert setup_arguments(text) == {"entry_points": {"a": ["b"]}}


@pytest.mark.parametrize(
    "text",
    [
        "x = 'a'\nfor i in [1, 2, 3, 4, 5, 6, 7, 8, 9]:\n" + "    x = x + x + x + x + x\n" * 9,
        "x = [0]\nfor i in 'a' 'b'.split():\n" + "    x.extend(x)\n" * 60,
        "setup(a='%1000000000d' % 1, b='{:1000000000}'.format(1), c=f'{1:1000000000}')",
        "def f(x):\n    return f(x)\nf(1)",
        "x = glob('/**', recursive=True) + glob('/**', recursive=True)",
        "[" * 5000,
        "-" * 100_000 + "1",
    ],
)
def test_a_script_that_would_take_the_machine_has_no_value(text, tmp_path):
    assert setup_arguments(text, tmp_path) == {}


@given(st.text())
def test_no_text_makes_the_reader_fail(text):
    assert isinstance(setup_arguments(text), dict)


_WORDS = st.sampled_from(
    (
        *("x", "y", "[", "]", "(", ")", "=", "+", ",", ".", ":", "'a'", "'b{}'", "%", "1", "for"),
        *("in", "if", "not", "def", "return", "append", "extend", "setup", "glob", "join"),
        *("\n", "\n    "),
    )
)


@given(st.lists(_WORDS, max_size=40))
def test_no_program_makes_the_reader_fail(words):
    assert isinstance(setup_arguments(" ".join(words)), dict)


@pytest.mark.parametrize(
    "script",
    [
        "project(arm)\ninstall(DIRECTORY bringup/up cad DESTINATION share/${PROJECT_NAME})",
        'PROJECT (arm)\ninstall (\n  DIRECTORY "bringup/" # all\n  DESTINATION share/arm/)\n',
        "set(to share/arm/up)\ninstall(FILES bringup/up/a.yaml DESTINATION ${to})",
        "install(PROGRAMS bringup/up/a.yaml\n  DESTINATION share/arm/up OPTIONAL)",
        "install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/bringup/up DESTINATION share/arm"
        ' PATTERN "*.in" EXCLUDE)',
    ],
)
def test_a_file_is_where_cmake_installs_it(arm, script):
    (arm / "bringup/up").mkdir()
    (arm / "bringup/up/a.yaml").touch()
    (arm / "CMakeLists.txt").write_text(script)
    share = packages.package_share("arm")
    assert (share / "up/a.yaml").resolve() == arm / "bringup/up/a.yaml"
    assert (share / "cad/a.stl").resolve() == arm / "cad/a.stl"


@pytest.mark.parametrize(
    "script",
    [
        "project(arm)\ninstall(DIRECTORY bringup config DESTINATION share/${PROJECT_NAME}/)",
        "install(TARGETS arm EXPORT export_arm RUNTIME DESTINATION bin)",
        "install(DIRECTORY bringup/ DESTINATION ${elsewhere})\ninstall(DIRECTORY bringup)",
        "install(DIRECTORY include/ DESTINATION include/arm)\ninstall(FILES",
        "# install(DIRECTORY bringup/ DESTINATION share/arm)",
    ],
)
def test_where_cmake_moves_nothing_the_source_folder_is_used(arm, script):
    (arm / "CMakeLists.txt").write_text(script)
    assert packages.package_share("arm") == arm


def test_files_that_are_installed_beside_the_share_folder_are_below_the_prefix(tmp_path):
    folder = tmp_path / "arm"
    (folder / "tools").mkdir(parents=True)
    (folder / "tools" / "wave.txt").write_text("hello")
    (folder / "setup.py").write_text(
        "from glob import glob\nfrom setuptools import setup\n"
        "setup(data_files=[('lib/arm', glob('tools/**')), ('share/arm', ['setup.py'])])\n"
    )
    prefix = prefix_folder("arm", folder, folder, ("wave",), is_source=True)
    assert (prefix / "lib" / "arm" / "wave.txt").read_text() == "hello"
    assert (prefix / "share" / "arm").resolve() == folder
