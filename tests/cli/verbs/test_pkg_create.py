"""``teleopctl pkg create``: the text and the files of ``ros2 pkg create``, which then work."""

import re
import sys
import tomllib
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

from teleopctl.packages import BUILD_TYPES, NewPackage, create_package, license_names
from teleopctl.packages.setup_script import setup_arguments
from tests.samples import sample

MAINTAINER = "--maintainer-name Ann --maintainer-email ann@example.com"

HEAD = """\
going to create a new package
package name: greeter
destination directory: {folder}
package format: 3
version: 0.0.0
description: TODO: Package description
maintainer: ['Ann <ann@example.com>']
licenses: ['{license}']
build type: {build_type}
dependencies: {dependencies}
"""

PYTHON = """\
node_name: talker
library_name: words
creating folder ./greeter
creating ./greeter/package.xml
creating source folder
creating folder ./greeter/greeter
creating ./greeter/setup.py
creating ./greeter/setup.cfg
creating folder ./greeter/resource
creating ./greeter/resource/greeter
creating ./greeter/greeter/__init__.py
creating folder ./greeter/test
creating ./greeter/test/test_copyright.py
creating ./greeter/test/test_flake8.py
creating ./greeter/test/test_pep257.py
creating ./greeter/greeter/talker.py
creating folder ./greeter/greeter/words
creating ./greeter/greeter/words/__init__.py
"""

CMAKE = """\
node_name: talker
library_name: words
creating folder ./greeter
creating ./greeter/package.xml
creating source and include folder
creating folder ./greeter/src
creating folder ./greeter/include/greeter
creating ./greeter/CMakeLists.txt
{config}creating ./greeter/src/talker.cpp
creating ./greeter/include/greeter/words.hpp
creating ./greeter/src/words.cpp
creating ./greeter/include/greeter/visibility_control.h
"""

CONFIG = """\
creating ./greeter/greeterConfig.cmake.in
creating ./greeter/greeterConfigVersion.cmake.in
"""

UNKNOWN_LICENSE = """
[WARNING]: Unknown license 'TODO: License declaration'.  This has been set in the package.xml, \
but no LICENSE file has been created.
It is recommended to use one of the ament license identifiers:
Apache-2.0
BSL-1.0
BSD-2.0
BSD-2-Clause
BSD-3-Clause
GPL-3.0-only
LGPL-3.0-only
MIT
MIT-0
"""

posix = pytest.mark.skipif(sys.platform == "win32", reason="the text has the separators of POSIX")


def files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def told_files(told: str) -> set[str]:
    return set(re.findall(r"^creating \./greeter/(\S+)$", told, re.MULTILINE))


@posix
def test_a_package_in_python_is_made_and_runs_at_once(ros_without_router):
    ros = ros_without_router
    made = ros.run(
        f"pkg create greeter --build-type ament_python {MAINTAINER} --license Apache-2.0"
        " --node-name talker --library-name words --dependencies rclpy std_msgs"
    )
    head = HEAD.format(
        folder=ros.folder,
        license="Apache-2.0",
        build_type="ament_python",
        dependencies=["rclpy", "std_msgs"],
    )
    assert (made.stdout, made.stderr, made.returncode) == (head + PYTHON, "", 0)
    assert files(ros.folder / "greeter") == told_files(PYTHON) | {"LICENSE"}
    assert ros.run("run greeter talker").stdout == "Hi from greeter.\n"
    assert ros.run("pkg executables greeter").stdout == "greeter talker\n"
    assert ros.run("pkg xml greeter --tag depend").stdout == "rclpy\nstd_msgs\n"
    again = ros.run("pkg create greeter --build-type ament_python")
    assert again.returncode == 1
    assert again.stdout == ""
    assert "Aborted! The directory already exists: ./greeter" in again.stderr


@posix
@pytest.mark.parametrize(("build_type", "config"), [("ament_cmake", ""), ("cmake", CONFIG)])
def test_a_package_in_cpp_is_made(ros_without_router, build_type, config):
    ros = ros_without_router
    chosen = "" if build_type == "ament_cmake" else f"--build-type {build_type}"
    made = ros.run(
        f"pkg create greeter {chosen} {MAINTAINER} --node-name talker --library-name words"
    )
    license_name = "TODO: License declaration"
    head = HEAD.format(
        folder=ros.folder, license=license_name, build_type=build_type, dependencies=[]
    )
    told = CMAKE.format(config=config)
    assert (made.stdout, made.returncode) == (head + told, 0)
    assert made.stderr == UNKNOWN_LICENSE
    assert files(ros.folder / "greeter") == told_files(told)


@posix
def test_a_package_in_rust_is_made(ros_without_router):
    ros = ros_without_router
    made = ros.run(
        f"pkg create greeter --build-type ament_cargo {MAINTAINER} --license MIT"
        " --node-name talker --library-name words --dependencies rclrs"
    )
    told = made.stdout.partition("library_name: words\n")[2]
    assert told == (
        "creating folder ./greeter\ncreating ./greeter/package.xml\ncreating source folder\n"
        "creating folder ./greeter/src\ncreating ./greeter/Cargo.toml\n"
        "creating ./greeter/src/main.rs\ncreating ./greeter/src/lib.rs\n"
    )
    cargo = tomllib.loads((ros.folder / "greeter/Cargo.toml").read_text())
    assert cargo["package"]["name"] == "greeter"
    assert cargo["bin"] == [{"name": "talker", "path": "src/main.rs"}]
    assert cargo["lib"]["name"] == "words"
    assert cargo["dependencies"] == {"rclrs": "*"}


def test_a_controller_is_made_with_a_test_that_passes(ros_without_router):
    ros = ros_without_router
    made = ros.run("pkg create arm_control --controller GentleArm")
    assert made.returncode == 0, made.stderr
    assert "build type: ament_python\n" in made.stdout
    folder = ros.folder / "arm_control"
    tested = ros.run_module("pytest", ["-q", "-p", "no:cacheprovider"], cwd=folder)
    assert "1 passed" in tested.stdout, tested.stdout
    parameters = yaml.safe_load((folder / "config/gentle_arm.yaml").read_text())
    manager = parameters["controller_manager"]["ros__parameters"]
    assert manager["gentle_arm"] == {"type": "arm_control/GentleArm"}
    points = setup_arguments((folder / "setup.py").read_text())["entry_points"]
    assert isinstance(points, dict)
    assert points["teleopctl.controllers"] == [
        "arm_control/GentleArm = arm_control.gentle_arm:GentleArm"
    ]


def test_licenses_are_listed_for_a_question_mark(ros_without_router):
    listed = ros_without_router.run("pkg create x --license ?").stdout.splitlines()
    assert listed == ["Supported licenses:", *license_names()]
    assert not (ros_without_router.folder / "x").exists()


@pytest.mark.parametrize(
    ("line", "told"),
    sample(
        [
            ("../greeter", "'../greeter' is not a valid package name"),
            (
                "test --build-type ament_python",
                "Aborted since 'ament_python' packages can't be named 'test'.",
            ),
            ("my-arm --build-type ament_python", "'my-arm' cannot be imported in Python"),
            ("arm --build-type ament_python --node-name class", "'class' cannot be imported"),
            ("arm --dependencies ../x", "'../x' is not a valid name"),
            ("", "Missing argument 'PACKAGE_NAME'"),
            ("arm --build-type catkin", "'catkin' is not one of"),
            (
                "arm --controller go --build-type cmake",
                "written in Python, and the build type is cmake",
            ),
            (
                "arm --controller 9",
                "'9' cannot be imported in Python, where the controller becomes",
            ),
        ],
        3,
    ),
)
def test_a_name_that_cannot_be_used_is_refused(ros_without_router, line, told):
    before = files(ros_without_router.folder)
    made = ros_without_router.run(f"pkg create {line}")
    assert made.returncode == 2
    assert told in made.stderr
    assert files(ros_without_router.folder) == before


def test_a_node_that_is_called_like_the_library_gets_another_name(ros_without_router):
    made = ros_without_router.run("pkg create arm --node-name arm --library-name arm")
    assert made.stderr.startswith(
        "[WARNING] node name can not be equal to the library name\n"
        "[WARNING] renaming node to arm_node\n"
    )
    assert (ros_without_router.folder / "arm/src/arm_node.cpp").is_file()


@pytest.mark.parametrize("build_type", BUILD_TYPES)
def test_what_people_write_stands_in_the_files_as_it_was_meant(tmp_path, build_type):
    said = 'It\'s "<5 & more" \\ é'
    package = NewPackage("arm", build_type, 2, said, "MIT", said, f"{said}@x", ("rclpy",), "go")
    create_package(package, str(tmp_path), lambda _: None)
    root = ElementTree.parse(tmp_path / "arm/package.xml").getroot()
    maintainer = root.find("maintainer")
    assert maintainer is not None
    assert (root.findtext("description"), maintainer.text) == (said, said)
    assert (root.get("format"), maintainer.get("email")) == ("2", f"{said}@x")
    assert root.findtext("export/build_type") == build_type
    assert said in (tmp_path / "arm/LICENSE").read_text(encoding="utf-8")
    if build_type == "ament_cargo":
        cargo = tomllib.loads((tmp_path / "arm/Cargo.toml").read_text(encoding="utf-8"))
        assert cargo["package"]["description"] == said
    if build_type == "ament_python":
        setup = setup_arguments((tmp_path / "arm/setup.py").read_text(encoding="utf-8"))
        assert (setup["description"], setup["maintainer"]) == (said, said)
        assert setup["entry_points"] == {"console_scripts": ["go = arm.go:main"]}


@pytest.mark.parametrize("name", license_names())
def test_every_license_has_its_text(tmp_path, name):
    package = NewPackage("arm", "cmake", 3, "", name, "Ann", "a@b")
    create_package(package, str(tmp_path), lambda _: None)
    text = (tmp_path / "arm/LICENSE").read_text(encoding="utf-8")
    assert len(text) > 900
    assert "{" not in text
