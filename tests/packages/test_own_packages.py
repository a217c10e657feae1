"""teleopctl's own packages: each is in the index, with a manifest and its files below a prefix."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

from teleopctl import packages, plugins
from teleopctl.interfaces.catalog import Catalog
from teleopctl.packages.own_packages import HERE, is_own_prefix, own_names, own_prefix
from teleopctl.plugins import lookup
from tests.distributions import install

INDEX = "share/ament_index/resource_index"


@pytest.fixture(scope="module")
def prefix():
    return own_prefix()


def test_every_package_of_interfaces_modules_programs_and_controllers_is_one(prefix):
    controllers = {name.partition("/")[0] for name in plugins.CONTROLLERS.builtin}
    interfaces = {name.partition("/")[0] for name in Catalog("jazzy").built_in_names()}
    served = {"rclpy", "launch", "launch_ros", "launch_testing", "tf2_ros", "cv_bridge", "rviz2"}
    assert controllers | interfaces | served <= own_names() <= set(packages.package_names())
    assert {marker.name for marker in (prefix / INDEX / "packages").iterdir()} == own_names()


def test_each_has_a_manifest_with_name_version_license_and_a_description_by_us(prefix):
    for name in own_names():
        root = ElementTree.parse(prefix / "share" / name / "package.xml").getroot()
        texts = {child.tag: child.text or "" for child in root}
        assert (texts["name"], texts["license"]) == (name, "Apache-2.0")
        assert [part.isdecimal() for part in texts["version"].split(".")] == [True] * 3, name
        # Otherwise the line of the package in own_packages.txt is missing.
        assert not texts["description"].endswith(", by teleopctl"), name


def test_interface_packages_have_their_definitions_and_the_list_of_them(prefix):
    listed = prefix / INDEX / "rosidl_interfaces"
    assert len(list(listed.iterdir())) > 130
    for package in ("std_msgs", "nav_msgs", "ur_msgs", "rmf_task_msgs", "carla_msgs"):
        files = (listed / package).read_text().split()
        assert files == sorted(
            f"{file.parent.name}/{file.name}" for file in (prefix / "share" / package).glob("*/*")
        )
    assert (prefix / "share/std_msgs/msg/String.msg").read_text() == "string data\n"
    assert packages.package_share("ur_msgs") == prefix / "share/ur_msgs"


def test_programs_are_below_lib_and_data_packages_keep_their_folder(prefix):
    assert (prefix / "lib/tf2_ros/tf2_echo").stat().st_mode & 0o700 == 0o700
    share = packages.package_share("teleop_description")
    assert (share / "urdf").is_dir()
    assert (prefix / "share/teleop_description").resolve() == share.resolve()


def test_the_prefix_in_the_environment_does_not_make_its_packages_installed_ones(
    prefix, monkeypatch
):
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(prefix))
    assert is_own_prefix(str(prefix))
    assert [layer.kind for layer in packages.package_layers("rclpy")] == ["own"]
    assert packages.search_paths() == [str(prefix)]


def test_a_source_package_of_the_name_comes_first_and_ours_second(tmp_path, monkeypatch):
    folder = tmp_path / "std_msgs"
    folder.mkdir()
    (folder / "package.xml").write_text("<package><name>std_msgs</name></package>")
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", str(tmp_path))
    assert [layer.kind for layer in packages.package_layers("std_msgs")] == ["sources", "own"]
    assert packages.package_share("std_msgs") == folder


def test_a_distribution_s_package_has_a_manifest_of_its_metadata(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    lookup.forget_entry_points()
    files = {"strange_claw/config/claw.yaml": "{}"}
    install(tmp_path, "strange-claw", {"teleopctl.packages": {"claw": "strange_claw"}}, files)
    found = packages.find_package("claw")
    root = ElementTree.parse(found.manifest).getroot()
    assert [root.findtext(tag) for tag in ("name", "version")] == ["claw", "1.0"]
    assert (found.prefix / "share/claw/config/claw.yaml").read_text() == "{}"
    lookup.forget_entry_points()


def test_ros_packages_that_pip_installed_beside_python_are_found(tmp_path, monkeypatch):
    marker = tmp_path / INDEX / "packages/osrf_like"
    marker.parent.mkdir(parents=True)
    marker.touch()
    monkeypatch.setattr("sys.prefix", str(tmp_path))
    assert packages.find_package("osrf_like").prefix == tmp_path


def test_interface_packages_have_the_version_that_their_definitions_are_from(prefix):
    sources = HERE / "interfaces/definitions/SOURCES.md"
    rows = [line.split(" | ") for line in sources.read_text("utf-8").splitlines() if "` | " in line]
    stated = {folder.strip("|` "): version for folder, _, version, _ in rows if "/" not in folder}
    assert len(stated) > 150
    written = {name: package_version(prefix, name) for name in stated}
    assert written == stated


def package_version(prefix: Path, name: str) -> str | None:
    return ElementTree.parse(prefix / "share" / name / "package.xml").findtext("version")
