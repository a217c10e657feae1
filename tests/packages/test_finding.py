"""Packages: which are found, what they offer, and what is said when they are not there."""

import os
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from teleopctl import packages
from teleopctl.errors import BrokenPluginError, TeleopctlError
from teleopctl.interfaces.catalog import Catalog
from teleopctl.packages import finding, source_folders, source_programs
from teleopctl.plugins import lookup
from tests.distributions import install

SETUP_PY = """
from setuptools import find_packages, setup
package_name = "my_pkg"
setup(
    name=package_name,
    entry_points={
        "console_scripts": [
            "talker = my_pkg.talker:main",
            "listener = " + package_name + ".listener:main",
            f"fancy = {package_name}.fancy:run",
        ],
    },
)
raise SystemExit("a package is read, never executed")
"""


@pytest.fixture(autouse=True)
def empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("TELEOPCTL_PACKAGE_PATH", raising=False)
    finding._packages_below.cache_clear()
    return tmp_path


def make_package(folder: Path, name: str, **files: str) -> Path:
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(
        f"<package><!-- <name>no</name> --><name>{name}</name></package>"
    )
    for file, text in files.items():
        (folder / file.replace("_dot_", ".")).write_text(text)
    return folder


@pytest.mark.parametrize(
    ("package", "executable", "target"),
    [
        ("robot_state_publisher", "robot_state_publisher", "robot_state_publisher:main"),
        ("controller_manager", "ros2_control_node", "controller_manager:main"),
        ("controller_manager", "spawner", "spawner:spawner"),
        ("tf2_ros", "tf2_echo", "tf2.tf2_echo:main"),
        ("teleop_py_pkg", "simple_publisher", "demos.simple_nodes:simple_publisher"),
        ("teleop_robot_py_pkg", "simple_parameter", "demos.simple_nodes:simple_parameter"),
        ("mujoco_sim", "mujoco_sim", "mujoco_sim:main"),
        ("camera", "camera", "camera:main"),
    ],
)
def test_built_in_executables_are_known_by_their_ros_names(package, executable, target):
    assert packages.find_executable(package, executable).target == f"teleopctl.nodes.{target}"


def test_every_built_in_executable_has_its_module():
    from importlib.util import find_spec

    for package in packages.list_packages():
        for executable in package.executables.values():
            assert find_spec(executable.target.partition(":")[0]), executable


@pytest.mark.parametrize(
    ("package", "file"),
    [
        ("teleop_description", "urdf/teleop.urdf.xacro"),
        ("teleop_controller", "teleop_controllers.yaml"),
    ],
)
def test_shares_of_the_robot_hold_its_files(package, file):
    assert (packages.package_share(package) / file).is_file()
    assert packages.resolve_uri(f"package://{package}/{file}").is_file()


def test_a_package_may_be_left_out_where_all_that_offer_a_name_mean_the_same_program():
    assert packages.find_executable(None, "simple_publisher").target.endswith(":simple_publisher")


def test_an_unknown_package_is_named_with_close_matches():
    with pytest.raises(TeleopctlError, match="Package 'tf2_ross' not found") as caught:
        packages.find_package("tf2_ross")
    assert "tf2_ros" in str(caught.value.hint)
    assert caught.value.exit_status == 1


def test_an_unknown_executable_is_named_with_close_matches():
    with pytest.raises(TeleopctlError, match="No executable found") as caught:
        packages.find_executable("teleop_py_pkg", "simple_publishr")
    assert "no executable 'simple_publishr'. Did you mean" in str(caught.value.hint)
    assert "simple_publisher" in str(caught.value.hint)


def test_a_source_package_offers_its_console_scripts_without_being_executed(empty_folder):
    make_package(empty_folder / "src" / "my_pkg", "my_pkg", setup_dot_py=SETUP_PY)
    found = packages.find_package("my_pkg")
    assert found.share == empty_folder / "src" / "my_pkg"
    assert {name: executable.target for name, executable in found.executables.items()} == {
        "talker": "my_pkg.talker:main",
        "listener": "my_pkg.listener:main",
        "fancy": "my_pkg.fancy:run",
    }
    assert found.executables["talker"].import_roots == (found.share,)


def test_scripts_are_read_from_setup_cfg_and_pyproject_too(empty_folder):
    folder = make_package(
        empty_folder / "p",
        "p",
        setup_dot_cfg="[options.entry_points]\nconsole_scripts =\n  one = p.one:main\n",
        pyproject_dot_toml='[project.scripts]\ntwo = "p.two:main"\n',
    )
    assert source_programs.console_scripts(folder) == {"one": "p.one:main", "two": "p.two:main"}


def test_a_launch_of_many_components_reads_each_script_of_the_workspace_once(
    empty_folder, monkeypatch
):
    for name in ("one", "two"):
        make_package(empty_folder / "src" / name, name, setup_dot_py=SETUP_PY)
    read: list[Path] = []

    def text_of(file: Path) -> str | None:
        read.append(file)
        return source_folders.text_of(file)

    monkeypatch.setattr(source_programs, "text_of", text_of)
    for component in ("nav2_amcl::AmclNode", "nav2_planner::PlannerServer"):
        with pytest.raises(TeleopctlError):
            packages.find_component(component.partition("::")[0], component)
    scripts = [file.parent.name for file in read if file.name == "setup.py"]
    assert sorted(scripts) == ["one", "two"]


# As in carla's packages for ROS 1 and 2.
SETUP_FOR_TWO = """
import os
ROS_VERSION = int(os.environ['ROS_VERSION'])
if ROS_VERSION == 1:
    from distutils.core import setup
    from catkin_pkg.python_setup import generate_distutils_setup
    d = generate_distutils_setup(packages=['carla_spawn'], package_dir={'': 'src'})
    setup(**d)
elif ROS_VERSION == 2:
    from setuptools import setup
    package_name = 'carla_spawn'
    setup(name=package_name, entry_points={'console_scripts': ['spawn = carla_spawn.spawn:main']})
"""


@pytest.mark.parametrize(
    "script",
    [
        SETUP_FOR_TWO,
        SETUP_FOR_TWO.replace("os.environ['ROS_VERSION']", "os.environ.get('ROS_VERSION', 0)"),
        SETUP_FOR_TWO.replace("int(os.environ['ROS_VERSION'])", "int(os.getenv('ROS_VERSION'))"),
        SETUP_FOR_TWO.replace("ROS_VERSION == 1", "ROS_VERSION < 2"),
        # Where the condition has no value, the call with entry points is taken.
        SETUP_FOR_TWO.replace("int(os.environ['ROS_VERSION'])", "detect()"),
    ],
)
def test_a_setup_for_ros_1_and_2_is_read_as_for_ros_2(empty_folder, monkeypatch, script):
    monkeypatch.delenv("ROS_VERSION", raising=False)
    folder = make_package(empty_folder / "carla_spawn", "carla_spawn", setup_dot_py=script)
    assert source_programs.console_scripts(folder) == {"spawn": "carla_spawn.spawn:main"}


def test_files_that_cannot_be_read_declare_nothing(empty_folder):
    folder = make_package(empty_folder / "p", "p", setup_dot_py="setup()\0")
    (folder / "setup.cfg").mkdir()
    assert source_programs.console_scripts(folder) == {}


def test_a_source_layout_is_imported_from_its_src_folder(empty_folder):
    folder = make_package(empty_folder / "p", "p")
    (folder / "src" / "p").mkdir(parents=True)
    assert source_programs.import_root(folder, "p.one:main") == folder / "src"


def test_packages_on_the_path_variable_are_found_from_anywhere(empty_folder, monkeypatch):
    make_package(empty_folder / "elsewhere" / "deep" / "q", "q")
    (empty_folder / "here").mkdir()
    monkeypatch.chdir(empty_folder / "here")
    with pytest.raises(TeleopctlError):
        packages.find_package("q")
    monkeypatch.setenv(
        "TELEOPCTL_PACKAGE_PATH", os.pathsep.join(["", str(empty_folder / "elsewhere")])
    )
    assert packages.package_share("q").name == "q"


@pytest.mark.parametrize("folder", [".hidden", "build", "install", "venv", "node_modules"])
def test_outputs_and_environments_are_not_searched(empty_folder, folder):
    make_package(empty_folder / folder / "r", "r")
    with pytest.raises(TeleopctlError):
        packages.find_package("r")


def test_a_virtual_environment_of_any_name_is_not_searched(empty_folder):
    make_package(empty_folder / "my-env" / "r", "r")
    (empty_folder / "my-env" / "pyvenv.cfg").touch()
    with pytest.raises(TeleopctlError):
        packages.find_package("r")


def test_a_users_package_overlays_a_built_in_one_and_leaves_it_its_executables(empty_folder):
    folder = make_package(
        empty_folder / "teleop_py_pkg",
        "teleop_py_pkg",
        setup_dot_py=SETUP_PY.replace("talker =", "simple_publisher ="),
    )
    found = packages.find_package("teleop_py_pkg")
    assert found.share == folder
    assert found.executables["simple_publisher"].target == "my_pkg.talker:main"
    assert found.executables["simple_subscriber"].target.startswith("teleopctl.nodes.")


CMAKE = "install(PROGRAMS scripts/{} DESTINATION lib/${{PROJECT_NAME}})\n"


@pytest.mark.parametrize("what", ["add_library(x SHARED x.cpp)", "add_executable(x x.cpp)", "Qt"])
def test_sources_that_are_of_no_use_before_they_are_built_stand_behind_ours(empty_folder, what):
    name = "gazebo_ros"
    script = "cmake_minimum_required(VERSION 3.8)\nproject(gazebo_ros)\n" + CMAKE.format("more.py")
    script += CMAKE.format("spawn_entity.py")
    folder = make_package(
        empty_folder / name, name, CMakeLists_dot_txt=script + ("" if what == "Qt" else what)
    )
    if what == "Qt":
        manifest = f"<name>{name}</name><exec_depend>python_qt_binding</exec_depend>"
        (folder / "package.xml").write_text(f"<package>{manifest}</package>")
    (folder / "scripts").mkdir()
    for program in ("more.py", "spawn_entity.py"):
        (folder / "scripts" / program).touch()
    found = packages.find_package(name)
    assert (found.share / "launch" / "gzserver.launch.py").is_file()
    assert found.executables["spawn_entity.py"].target.startswith("teleopctl.nodes.")
    assert found.executables["more.py"].file == folder / "scripts" / "more.py"
    hidden = packages.package_layers(name)[1]
    assert (hidden.folder, hidden.found_by) == (folder, "below the current folder, not built")


def test_unbuilt_sources_give_the_files_where_ours_has_none(empty_folder):
    name = "controller_manager"
    script = "# add_executable(no no.cpp)\nadd_executable(yes yes.cpp)\n"
    folder = make_package(
        empty_folder / name, name, CMakeLists_dot_txt=script, setup_dot_py=SETUP_PY
    )
    found = packages.find_package(name)
    assert (found.folder, "talker" in found.executables) == (folder, True)
    assert found.executables["spawner"].target == "teleopctl.nodes.spawner:spawner"


def test_a_comment_in_a_cmakelists_compiles_nothing(empty_folder):
    script = "# add_executable(no no.cpp)\n"
    folder = make_package(empty_folder / "rviz2", "rviz2", CMakeLists_dot_txt=script)
    assert packages.package_layers("rviz2")[0].folder == folder


def test_a_name_that_means_different_programs_has_to_be_qualified(empty_folder):
    for name in ("one", "two"):
        make_package(empty_folder / name, name, setup_dot_py=SETUP_PY)
    with pytest.raises(
        TeleopctlError, match="Several packages have an executable 'talker'"
    ) as caught:
        packages.find_executable(None, "talker")
    assert caught.value.exit_status == 2


def test_a_program_of_ones_own_comes_before_ours_of_the_name(empty_folder):
    # Two packages of demos have it.
    make_package(empty_folder / "mine", "mine", setup_dot_py=SETUP_PY)
    assert packages.find_executable(None, "talker").package == "mine"


def test_a_file_is_an_executable(empty_folder):
    (empty_folder / "node.py").touch()
    found = packages.find_executable(None, "./node.py")
    assert found.file == empty_folder / "node.py"
    with pytest.raises(TeleopctlError, match="No executable found"):
        packages.find_executable(None, "./other.py")


def test_uris_become_paths():
    assert packages.resolve_uri("/a/b.stl") == Path("/a/b.stl")
    assert packages.resolve_uri("file:///a/b%20c.stl") == Path("/a/b c.stl")
    with pytest.raises(TeleopctlError, match="nope"):
        packages.resolve_uri("package://nope/x")
    with pytest.raises(TeleopctlError, match="https://x/y"):
        packages.resolve_uri("https://x/y")


@given(st.text())
def test_no_setup_py_makes_the_reader_fail(text):
    assert isinstance(source_programs._of_setup_py(text, "console_scripts"), dict)
    assert isinstance(source_programs._of_setup_cfg(text, "console_scripts"), dict)
    assert isinstance(source_programs._of_pyproject(text, "console_scripts"), dict)


@pytest.fixture
def site(tmp_path, monkeypatch):
    folder = tmp_path / "site"
    monkeypatch.syspath_prepend(str(folder))
    lookup.forget_entry_points()
    yield folder
    lookup.forget_entry_points()


def test_an_installed_distribution_brings_a_package_of_files(site):
    entries = {"strange_arm": "strange_arm_files", "strange_data": "strange_arm_files.share"}
    files = {"strange_arm_files/launch/up.yaml": "", "strange_arm_files/share/a.txt": "A"}
    install(site, "strange-arm", {"teleopctl.packages": entries}, files)
    assert packages.package_share("strange_arm") == site / "strange_arm_files"
    assert packages.resolve_uri("package://strange_data/a.txt").read_text() == "A"
    assert {"strange_arm", "strange_data"} <= {found.name for found in packages.list_packages()}


def test_a_package_of_a_distribution_has_its_nodes_too(site):
    groups = {
        "teleopctl.packages": {"strange_arm": "strange_arm_files"},
        "teleopctl.nodes": {"strange_arm/talk": "strange_arm_code:main"},
    }
    install(site, "strange-arm", groups, {"strange_arm_files/x": "", "strange_arm_code.py": ""})
    found = packages.find_package("strange_arm")
    assert found.share == site / "strange_arm_files"
    assert found.executables["talk"].target == "strange_arm_code:main"


def test_a_package_whose_files_are_missing_is_told_where_it_is_used_and_nowhere_else(site):
    install(site, "strange-arm", {"teleopctl.packages": {"strange_arm": "not_there"}})
    assert "strange_arm" not in {found.name for found in packages.list_packages()}
    with pytest.raises(BrokenPluginError, match=r"strange_arm' of strange-arm: .* not_there"):
        packages.find_package("strange_arm")


def test_entry_points_are_read_only_for_what_nothing_else_knows(monkeypatch, empty_folder):
    make_package(empty_folder / "mine", "mine")
    monkeypatch.setattr(lookup, "_installed", None)
    assert packages.lookup_package("mine")
    assert packages.lookup_package("teleop_description")
    assert packages.lookup_package("tf2_ros")


def test_an_installed_distribution_brings_messages(site):
    files = {"strange_msgs_files/msg/Grip.msg": "float64 force\n"}
    install(site, "strange", {"teleopctl.packages": {"strange_msgs": "strange_msgs_files"}}, files)
    catalog = Catalog()
    definition = catalog.find("strange_msgs/msg/Grip")
    assert definition is not None
    assert [field.name for field in definition.fields] == ["force"]
    assert catalog.package_names("strange_msgs") == ["strange_msgs/msg/Grip"]
    assert "strange_msgs/msg/Grip" in catalog.names()


def test_packages_are_found_however_deep_they_lie(empty_folder):
    make_package(empty_folder / "src/examples/rclpy/topics/minimal_publisher", "minimal")
    assert packages.package_share("minimal").name == "minimal_publisher"


def test_a_package_is_found_from_inside_its_own_folder(tmp_path, monkeypatch):
    folder = make_package(tmp_path / "head", "head")
    inside = folder / "launch" / "sim"
    inside.mkdir(parents=True)
    monkeypatch.chdir(inside)
    assert packages.package_share("head") == folder


def test_a_package_below_comes_before_the_one_around(tmp_path, monkeypatch):
    make_package(tmp_path / "around", "head")
    below = make_package(tmp_path / "around" / "src" / "head", "head")
    monkeypatch.chdir(below.parent)
    assert packages.package_share("head") == below


def test_the_package_of_a_file_given_by_path_is_found_also_by_processes_started(
    tmp_path, monkeypatch
):
    folder = make_package(tmp_path / "away" / "arm", "arm")
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", "")
    packages.include_package_of(Path("../away/arm/urdf/arm.urdf.xacro"))
    assert packages.resolve_uri("package://arm/meshes/a.stl") == folder / "meshes/a.stl"
    assert os.environ["TELEOPCTL_PACKAGE_PATH"] == str(folder)


def test_the_package_of_a_file_is_meant_whatever_lies_below_the_current_folder(
    tmp_path, monkeypatch
):
    folder = make_package(tmp_path / "away" / "arm", "arm")
    make_package(tmp_path / "here" / "arm", "arm")
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", "")
    packages.include_package_of(folder / "launch" / "up.yaml")
    assert packages.package_share("arm") == folder


@pytest.mark.parametrize("mark", ["src", ".git"])
def test_the_packages_beside_that_of_a_file_given_by_path_are_found(tmp_path, monkeypatch, mark):
    workspace = tmp_path / "away" / ("src" if mark == "src" else "repository")
    bringup = make_package(workspace / "bringup", "arm_bringup")
    description = make_package(workspace / "deep" / "description", "arm_description")
    (workspace / mark).mkdir()
    make_package(tmp_path / "other" / "src" / "description", "arm_description")
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", "")
    packages.include_package_of(bringup / "launch" / "up.launch.py")
    assert packages.package_share("arm_description") == description
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", "")
    monkeypatch.chdir(workspace)
    packages.include_package_of(bringup / "launch" / "up.launch.py")
    assert os.environ["TELEOPCTL_PACKAGE_PATH"] == str(bringup)


def test_the_package_of_a_file_hides_none_of_the_folders_named(tmp_path, monkeypatch):
    named = make_package(tmp_path / "named", "arm")
    make_package(tmp_path / "away", "arm")
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", str(named))
    packages.include_package_of(tmp_path / "away" / "arm.urdf")
    assert packages.package_share("arm") == named


def test_a_search_that_was_cut_off_says_so_where_a_package_is_missing(tmp_path, monkeypatch):
    monkeypatch.setattr(source_folders, "_MAX_FOLDERS", 50)
    for number in range(source_folders._MAX_FOLDERS):
        (tmp_path / f"{number:03}").mkdir()
    make_package(tmp_path / "zzz", "unseen_thing")
    with pytest.raises(TeleopctlError) as failure:
        packages.find_package("unseen_thing")
    assert "more than the 50 folders that are searched" in str(failure.value.hint)
    assert "TELEOPCTL_PACKAGE_PATH" in str(failure.value.hint)
