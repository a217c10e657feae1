"""``teleopctl pkg``: the packages that there are, and what hides what."""

import json
from pathlib import Path


def test_every_package_is_listed_with_its_folder(ros_without_router):
    listed = ros_without_router.run("pkg list").stdout.split()
    assert {"controller_manager", "teleop_description", "teleopctl"} <= set(listed)
    folders = {
        entry["name"]: entry["folder"]
        for entry in json.loads(ros_without_router.run("pkg list --json").stdout)
    }
    assert list(folders) == listed
    assert (Path(folders["teleop_description"]) / "urdf" / "teleop.urdf.xacro").is_file()
    prefix = ros_without_router.run("pkg prefix teleop_description").stdout
    assert prefix == folders["teleop_description"] + "\n"


def test_the_folder_that_a_name_means_is_told_and_what_it_hides(ros_without_router):
    ros = ros_without_router
    before = ros.run("pkg prefix controller_manager")
    own = before.stdout.removesuffix("\n")
    assert (Path(own).name, before.stderr) == ("teleopctl", "")
    folder = ros.folder / "controller_manager"
    folder.mkdir()
    (folder / "package.xml").write_text("<package><name>controller_manager</name></package>")
    after = ros.run("pkg prefix controller_manager")
    assert after.stdout == f"{folder}\n"
    assert after.stderr == (f"It hides {own} (programs: ros2_control_node, spawner, unspawner)\n")


def test_a_package_that_does_not_exist_is_an_error_with_close_names(ros_without_router):
    result = ros_without_router.run("pkg prefix controler_manager")
    assert (result.stdout, result.returncode) == ("", 1)
    assert "Package 'controler_manager' not found" in result.stderr
    assert "controller_manager" in result.stderr
