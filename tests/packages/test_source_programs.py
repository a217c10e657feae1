"""Programs and modules of source packages: what colcon would install, run where it lies."""

import sys

import pytest

from teleopctl.errors import NotFoundError
from teleopctl.packages import find_executable, source_module_root
from teleopctl.packages.cmake_script import installation
from teleopctl.packages.source_programs import executables
from tests.packages.prefix import write

CMAKE = """
cmake_minimum_required(VERSION 3.8)
project(arm)
find_package(ament_cmake_python REQUIRED)  # install(PROGRAMS no.py DESTINATION lib/arm)
ament_python_install_package(${{PROJECT_NAME}} PACKAGE_DIR python)
{rule}
ament_package()
"""


@pytest.fixture
def arm(tmp_path):
    folder = tmp_path / "arm"
    write(folder / "package.xml", "<package><name>arm</name></package>")
    write(folder / "scripts/wave.py", "#!/usr/bin/env python3\nprint('wave')\n", 0o755)
    write(folder / "scripts/nod", "#!/usr/bin/env python3\nprint('nod')\n", 0o755)
    write(folder / "scripts/notes.txt", "no program")
    return folder


@pytest.mark.parametrize(
    ("rule", "names"),
    [
        ("install(PROGRAMS scripts/wave.py DESTINATION lib/${PROJECT_NAME})", "wave.py"),
        ("install(PROGRAMS scripts/wave.py DESTINATION lib/arm RENAME wave)", "wave"),
        ("install(PROGRAMS scripts/gone.py DESTINATION lib/arm)", ""),
        ("install(PROGRAMS scripts/wave.py DESTINATION share/arm)", ""),
        ("set(all scripts/wave.py scripts/nod)\ninstall(PROGRAMS ${all} DESTINATION lib/arm)", "*"),
        (
            "list(APPEND all scripts/nod)\nforeach(script ${all} scripts/wave.py)\n"
            '  install(PROGRAMS "${script}" DESTINATION "lib/${PROJECT_NAME}")\nendforeach()',
            "*",
        ),
        (
            "set(all scripts/nod scripts/wave.py)\nforeach(s IN LISTS all)\n"
            "  install(PROGRAMS ${s} DESTINATION lib/arm)\nendforeach()",
            "*",
        ),
        ("file(GLOB all scripts/*)\ninstall(PROGRAMS ${all} DESTINATION lib/arm)", "* notes.txt"),
        (
            "file(GLOB all LIST_DIRECTORIES FALSE\n"
            "RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS\n"
            "  ${CMAKE_CURRENT_SOURCE_DIR}/scripts/*.py)\n"
            "install(PROGRAMS ${all} DESTINATION lib/arm)",
            "wave.py",
        ),
        ("install(DIRECTORY scripts/ DESTINATION lib/arm USE_SOURCE_PERMISSIONS)", "*"),
        ("install(DIRECTORY scripts DESTINATION lib/arm)", "*"),
        ("add_subdirectory(scripts)", "nod"),
        ("install(TARGETS wave.py DESTINATION lib/arm)", ""),
        ("if(UNIX AND (NOT APPLE))\n install(PROGRAMS scripts/nod DESTINATION lib/arm)", "nod"),
        ("catkin_install_python(PROGRAMS scripts/nod DESTINATION lib/${PROJECT_NAME})", "nod"),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="no permissions to run")
def test_scripts_that_cmake_installs_are_programs(arm, rule, names):
    write(
        arm / "scripts/CMakeLists.txt",
        "install(PROGRAMS ${CMAKE_CURRENT_SOURCE_DIR}/nod DESTINATION lib/${PROJECT_NAME})",
    )
    (arm / "CMakeLists.txt").write_text(CMAKE.format(rule=rule))
    names = names.replace("*", "nod wave.py")
    found = {name for name in executables("arm", arm) if name != "CMakeLists.txt"}
    assert found == set(names.split())


@pytest.mark.parametrize(
    "rule",
    [
        "add_executable(wave src/wave.cpp)\ninstall(TARGETS wave DESTINATION lib/${PROJECT_NAME})",
        "install(TARGETS\n  wave nod\n  EXPORT arm ARCHIVE DESTINATION lib\n"
        "  RUNTIME DESTINATION lib/arm\n)",
        'rclcpp_components_register_node(arm_node PLUGIN "arm::Wave" EXECUTABLE wave)',
    ],
)
def test_a_program_that_is_not_compiled_is_told_from_one_that_does_not_exist(
    arm, monkeypatch, rule
):
    (arm / "CMakeLists.txt").write_text(CMAKE.format(rule=rule))
    monkeypatch.chdir(arm)
    with pytest.raises(NotFoundError, match="'wave' of package 'arm' is compiled") as caught:
        find_executable("arm", "wave")
    assert str(arm / "CMakeLists.txt") in str(caught.value.hint)
    with pytest.raises(NotFoundError, match=r"No executable found$"):
        find_executable("arm", "wade")


@pytest.mark.parametrize(
    "text",
    [
        "foreach(a b c)\n" * 40 + "set(x 1)",
        "install(PROGRAMS ${",
        "add_subdirectory(.)",
        "file(GLOB x ${PROJECT_SOURCE_DIR} .)",
        "file(GLOB x /etc/* ../*)\ninstall(PROGRAMS ${x} DESTINATION lib/arm)",
        "file(GLOB)\nfile(GLOB x RELATIVE)\nlist(APPEND)\nset()\ninstall(FILES DESTINATION)",
    ],
)
def test_a_script_that_means_nothing_is_no_mistake(arm, text):
    (arm / "CMakeLists.txt").write_text(text)
    assert installation(text, arm).modules == {}


def test_a_script_runs_and_imports_what_its_and_other_packages_install(arm, ros_without_router):
    ros = ros_without_router
    (ros.folder / "src").mkdir()
    rule = "install(PROGRAMS scripts/wave.py DESTINATION lib/arm)"
    (arm / "CMakeLists.txt").write_text(CMAKE.format(rule=rule))
    write(arm / "python/__init__.py", "NAME = 'arm'\n")
    write(arm / "scripts/sibling.py", "from hand.fingers import COUNT\n")
    write(
        arm / "scripts/wave.py",
        "import sibling, arm\nfrom hand_msgs.msg import Grip\n"
        "print(arm.NAME, sibling.COUNT, Grip(force=1.0).force)\n",
    )
    arm.rename(ros.folder / "src/arm")
    for name in ("hand", "hand_msgs"):
        manifest = f"<package><name>{name}</name></package>"
        write(ros.folder / f"src/{name}/package.xml", manifest)
    write(ros.folder / "src/hand/hand/__init__.py", "")
    write(ros.folder / "src/hand/hand/fingers.py", "COUNT = 5\n")
    write(ros.folder / "src/hand_msgs/msg/Grip.msg", "float64 force\n")
    done = ros.run("run arm wave.py")
    assert (done.stdout, done.stderr) == ("arm 5 1.0\n", "")


@pytest.mark.parametrize("mark", ["COLCON_IGNORE", "AMENT_IGNORE", "CATKIN_IGNORE"])
def test_a_folder_that_is_marked_is_not_searched(arm, ros_without_router, mark):
    write(ros_without_router.folder / "src/package.xml", "<package><name>hand</name></package>")
    assert "hand" in ros_without_router.run("pkg list").stdout.split()
    write(ros_without_router.folder / "src" / mark, "")
    assert "hand" not in ros_without_router.run("pkg list").stdout.split()


@pytest.mark.skipif(sys.platform == "win32", reason="links are for administrators there")
def test_links_to_folders_are_followed_once(arm, ros_without_router):
    ros = ros_without_router
    for folder in ("src", ".hidden"):
        (ros.folder / folder).mkdir()
    arm.rename(ros.folder / ".hidden/arm")
    (ros.folder / "src/around").symlink_to(ros.folder)
    (ros.folder / "src/linked").symlink_to(ros.folder / ".hidden/arm")
    told = ros.run("pkg list --verbose")
    assert f"arm  {ros.folder}/src/linked  [below the current folder]\n" in told.stdout
    assert told.stderr == ""


def test_a_module_is_found_by_its_name_whatever_package_installs_it(tmp_path, monkeypatch):
    by_cmake, by_setup = tmp_path / "follower", tmp_path / "driver"
    for folder in (by_cmake, by_setup):
        write(folder / "package.xml", f"<package><name>{folder.name}</name></package>")
        write(folder / "helpers/__init__.py", "")
    write(by_cmake / "CMakeLists.txt", "ament_python_install_package(line_following)\n")
    write(by_cmake / "line_following/__init__.py", "")
    write(by_setup / "setup.py", "from setuptools import setup\nsetup(packages=['motor'])\n")
    write(by_setup / "src/motor/__init__.py", "")
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", str(tmp_path))

    assert source_module_root("line_following") == by_cmake
    assert source_module_root("motor") == by_setup / "src"
    assert source_module_root("helpers") == by_setup, "nothing installs the other one"
    assert source_module_root("numpy") is None
