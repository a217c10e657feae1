"""``teleopctl interface stubs``."""

import ast
from pathlib import Path

import pytest

PACKAGE_XML = "<package><name>gadget_msgs</name></package>"


@pytest.fixture
def workspace(ros):
    package = ros.folder / "workspace" / "gadget_msgs"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text(PACKAGE_XML)
    (package / "msg" / "Gadget.msg").write_text("std_msgs/Header header\nfloat64 force\n")
    return package.parent


def test_the_stubs_of_ones_own_packages_are_written(ros, workspace):
    done = ros.run("interface stubs typings", cwd=workspace)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "Wrote gadget_msgs to typings\n"
    assert 'mypy_path = "typings"' in done.stderr
    assert 'stubPath = "typings"' in done.stderr
    (package,) = (workspace / "typings").iterdir()
    assert package.name == "gadget_msgs"
    stub = ast.parse((package / "msg.pyi").read_text())
    assert [node.name for node in stub.body if isinstance(node, ast.ClassDef)] == ["Gadget"]


def test_all_packages_are_those_of_the_distribution(ros, workspace):
    ros.env["ROS_DISTRO"] = "kilted"
    done = ros.run("interface stubs --all typings", cwd=workspace)
    assert done.returncode == 0, done.stderr
    written = {path.name for path in (workspace / "typings").iterdir()}
    assert written > {"gadget_msgs", "std_msgs", "rcl_interfaces", "example_interfaces"}
    pid_state = Path(workspace, "typings/control_msgs/msg.pyi").read_text()
    assert "class PidState(_Message):" in pid_state


def test_without_packages_of_ones_own_there_is_nothing_to_write(ros):
    done = ros.run("interface stubs typings")
    assert done.returncode == 1
    assert "No package of your own defines" in done.stderr
    assert not (ros.folder / "typings").exists()


@pytest.mark.parametrize("manifest", ["<package><name>gadget_msgs</name", "<package/>", ""])
def test_a_package_without_a_readable_name_is_named_where_its_messages_are_missed(
    ros, workspace, manifest
):
    file = workspace / "gadget_msgs" / "package.xml"
    file.write_text(manifest)
    fault = f"{file} has no readable <name>"
    done = ros.run("interface stubs typings", cwd=workspace)
    assert done.returncode == 1
    assert done.stderr.startswith(f"WARNING: {fault}")
    assert fault in ros.run("pkg prefix gadget_msgs", cwd=workspace).stderr


def test_a_folder_that_is_called_like_a_definition_is_none(ros, workspace):
    (workspace / "gadget_msgs" / "msg" / "Folder.msg").mkdir()
    assert ros.run("interface stubs typings", cwd=workspace).returncode == 0
