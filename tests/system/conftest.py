"""Fixtures of several test modules."""

import pytest

from tests import ROOT


@pytest.fixture
def start_stranger(ros, tmp_path_factory):
    """Fixture: function that starts a node with types of a package that only the node can find."""
    # Not below the working directory of the commands, where packages are found.
    folder = tmp_path_factory.mktemp("stranger")
    package = folder / "strange_msgs"
    for kind, name, text in (
        ("msg", "Goals", "string[] names\nstrange_msgs/Place where\n"),
        ("msg", "Place", "float64 x\n"),
        ("srv", "Pick", "Goals goals\n---\nint32 number\n"),
    ):
        (package / kind).mkdir(parents=True, exist_ok=True)
        (package / kind / f"{name}.{kind}").write_text(text)
    (package / "package.xml").write_text("<package><name>strange_msgs</name></package>")

    def start_one(*options):
        ros.env["TELEOPCTL_PACKAGE_PATH"] = str(folder)
        node = ros.spawn_module("tests.system.stranger", options, cwd=ROOT)
        del ros.env["TELEOPCTL_PACKAGE_PATH"]
        node.wait_for_line("up")
        return node

    return start_one


@pytest.fixture
def stranger(start_stranger):
    """Fixture: node of `start_stranger` that serves its type descriptions."""
    return start_stranger()
