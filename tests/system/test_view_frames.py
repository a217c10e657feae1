"""``view_frames``: the tree of frames as files, of real broadcasters."""

import os
import stat
import sys
from xml.etree import ElementTree

import pytest

from teleopctl.nodes.tf2.view_frames import frames_diagram
from teleopctl.tf import KnownFrame
from tests.samples import sample

CHAIN = (("world", "base"), ("base", "arm"))
COMMANDS = ["tf view_frames", "run tf2_tools view_frames"]


@pytest.fixture
def frames(ros):
    for parent, child in CHAIN:
        words = f"--x 1 --frame-id {parent} --child-frame-id {child}"
        ros.spawn(f"run tf2_ros static_transform_publisher {words}").wait_for_line("Spinning")
    return ros


def without_dot(ros, folder):
    """No `dot` on the path, whatever is installed on the machine."""
    ros.env["PATH"] = str(folder)


@pytest.mark.parametrize("command", sample(COMMANDS, 2))
def test_the_tree_is_written_as_a_graph_and_as_a_picture(frames, tmp_path, command):
    without_dot(frames, tmp_path)
    done = frames.run(f"{command} -t 1 -o {tmp_path}/tree")
    assert done.returncode == 0, done.stderr
    graph = (tmp_path / "tree.gv").read_text()
    assert '"world" -> "base"[label="Broadcaster: ' in graph
    assert '"base" -> "arm"[label="' in graph
    svg = ElementTree.parse(tmp_path / "tree.svg")
    texts = [element.text for element in svg.iter() if element.tag.endswith("text")]
    assert {"world", "base", "arm", "static"} <= set(texts)
    assert not (tmp_path / "tree.pdf").exists()
    assert "dot" in done.stderr
    if command.startswith("run"):
        lines = [line.partition(" [view_frames]: ")[2] for line in done.stderr.splitlines()]
        assert [line for line in lines if "dot" not in line] == [
            "Listening to tf data for 1.0 seconds...",
            "Generating graph...",
            f"Exporting graph in {tmp_path}/tree.gv file...",
            f"Exporting graph in {tmp_path}/tree.svg file...",
        ]


@pytest.mark.skipif(sys.platform == "win32", reason="the stand-in for dot is a shell script")
def test_where_dot_is_installed_there_is_a_pdf(frames, tmp_path):
    dot = tmp_path / "dot"
    dot.write_text('#!/bin/sh\necho "$@" > "$4.words"\necho "%PDF" > "$4"\n')
    dot.chmod(dot.stat().st_mode | stat.S_IXUSR)
    frames.env["PATH"] = f"{tmp_path}{os.pathsep}{frames.env['PATH']}"
    done = frames.run(f"tf view_frames -t 1 -o {tmp_path}/tree")
    assert done.stdout.split() == [f"{tmp_path}/tree.{end}" for end in ("gv", "svg", "pdf")]
    words = (tmp_path / "tree.pdf.words").read_text()
    assert words == f"-Tpdf {tmp_path}/tree.gv -o {tmp_path}/tree.pdf\n"


def test_without_a_name_the_files_have_the_time_in_theirs(frames, tmp_path):
    without_dot(frames, tmp_path)
    done = frames.run("tf view_frames -t 1")
    graph, svg = done.stdout.split()
    assert graph.startswith("frames_2")
    assert (graph[-3:], svg[-4:]) == (".gv", ".svg")


@pytest.mark.parametrize("command", COMMANDS)
def test_where_nothing_is_broadcast_that_is_told(ros, tmp_path, command):
    done = ros.run(f"{command} -t 0.3 -o {tmp_path}/tree")
    assert done.returncode == 1
    assert "No transform on /tf or /tf_static within 0.3 s" in done.stderr
    assert not list(tmp_path.glob("tree*"))


def test_a_file_that_cannot_be_written_is_told(frames, tmp_path):
    done = frames.run(f"tf view_frames -t 0.5 -o {tmp_path}/no/such/tree")
    assert done.returncode == 1
    assert "Cannot write" in done.stderr


def test_names_of_others_cannot_break_out_of_the_picture():
    frame = KnownFrame('a"</text><script>', "b\x1b[31m", "c\nd", 0.0, 0.0, 0.0, True)
    diagram = frames_diagram([frame])
    assert not any("\x1b" in box.text for box in diagram.boxes)
