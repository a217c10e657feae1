"""Containers in launch files: Python, YAML and XML say the same, and it is known before."""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import dedent
from typing import Any
from xml.etree import ElementTree

import pytest
import yaml
from hypothesis import given, strategies as st

from teleopctl.errors import NotFoundError
from teleopctl.launch import CallSequence, LaunchPlan
from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.frontends import read_launch_file
from teleopctl.launch.model.request import LaunchRequest
from teleopctl.launch.service_calls import ComponentLoading

WORDS = st.sampled_from(["alice", "bob", "left_arm", "image", "speed"])
PLUGINS = st.sampled_from(["composition::Talker", "composition::Listener", "composition::Server"])
VALUES = st.one_of(WORDS, st.booleans(), st.integers(-9, 9), st.just(0.5), st.just([1, 2]))
COMPONENTS = st.fixed_dictionaries(
    {"plugin": PLUGINS, "name": WORDS},
    optional={
        "namespace": st.sampled_from(["", "left", "/right"]),
        "param": st.dictionaries(WORDS, VALUES, min_size=1, max_size=2),
        "remap": st.dictionaries(WORDS, WORDS, min_size=1, max_size=2),
        "extra_arg": st.dictionaries(
            st.sampled_from(["use_intra_process_comms", "enable_rosout"]),
            st.booleans(),
            min_size=1,
        ),
        "if": st.booleans(),
        "autostart": st.booleans(),
    },
)
Component = dict[str, Any]
Say = Any


def as_python(pushed: str, inside: list[Component], later: list[Component]) -> str:
    def one(component: Component) -> str:
        given = dict(component)
        words = {
            "package": "composition",
            "plugin": given.pop("plugin"),
            "parameters": [given.pop("param", {})],
            "remappings": list(given.pop("remap", {}).items()),
            "extra_arguments": [given.pop("extra_arg", {})],
        }
        condition = given.pop("if", None)
        kind = "ComposableLifecycleNode" if "autostart" in given else "ComposableNode"
        arguments = [f"{name}={value!r}" for name, value in (words | given).items()]
        if condition is not None:
            arguments.append(f"condition=IfCondition({str(condition).lower()!r})")
        return f"{kind}({', '.join(arguments)})"

    # The two kinds are two lists in a text.
    def ordered(components: list[Component]) -> str:
        return f"[{', '.join(map(one, sorted(components, key=lambda c: 'autostart' in c)))}]"

    return dedent(f"""
        from launch import LaunchDescription
        from launch.conditions import IfCondition
        from launch_ros.actions import (
            ComposableNodeContainer, LoadComposableNodes, PushRosNamespace, SetParameter, SetRemap,
        )
        from launch_ros.descriptions import ComposableLifecycleNode, ComposableNode

        def generate_launch_description():
            return LaunchDescription([
                SetParameter("use_sim_time", True),
                SetRemap("tf", "/tf"),
                PushRosNamespace({pushed!r}),
                ComposableNodeContainer(
                    package="rclcpp_components", executable="component_container_mt", name="box",
                    namespace="", composable_node_descriptions={ordered(inside)},
                ),
                LoadComposableNodes(
                    target_container={f"/{pushed}/box"!r},
                    composable_node_descriptions={ordered(later)},
                ),
            ])
        """)


def as_tree(pushed: str, inside: list[Component], later: list[Component]) -> list[Any]:
    def one(component: Component) -> dict[str, Any]:
        written: dict[str, Any] = {"pkg": "composition", **component}
        for key, (first, second) in {
            "param": ("name", "value"),
            "remap": ("from", "to"),
            "extra_arg": ("name", "value"),
        }.items():
            if key in component:
                pairs = component[key].items()
                written[key] = [{first: name, second: value} for name, value in pairs]
        return written

    def lists(components: list[Component]) -> dict[str, Any]:
        kinds = {"composable_node": False, "composable_lifecycle_node": True}
        found = {
            key: [one(each) for each in components if ("autostart" in each) == has_life]
            for key, has_life in kinds.items()
        }
        return {key: entries for key, entries in found.items() if entries}

    container = {"pkg": "rclcpp_components", "exec": "component_container_mt", "name": "box"}
    return [
        {"set_parameter": {"name": "use_sim_time", "value": True}},
        {"set_remap": {"from": "tf", "to": "/tf"}},
        {"push_ros_namespace": {"namespace": pushed}},
        {"node_container": {**container, "namespace": "", **lists(inside)}},
        {"load_composable_node": {"target": f"/{pushed}/box", **lists(later)}},
    ]


def as_yaml(*said: Any) -> str:
    return yaml.safe_dump({"launch": as_tree(*said)})


def as_xml(*said: Any) -> str:
    def tag(name: str, content: dict[str, Any]) -> ElementTree.Element:
        element = ElementTree.Element(name)
        for key, value in content.items():
            if isinstance(value, list) and value and isinstance(value[0], dict):
                element.extend(tag(key, each) for each in value)
            elif isinstance(value, list):
                element.set(key, ",".join(map(str, value)))
                element.set(f"{key}-sep", ",")
            else:
                element.set(key, str(value).lower() if isinstance(value, bool) else str(value))
        return element

    root = ElementTree.Element("launch")
    root.extend(tag(*next(iter(action.items()))) for action in as_tree(*said))
    return ElementTree.tostring(root, encoding="unicode")


def planned(folder: Path, name: str, text: str, **words: Any) -> LaunchPlan:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    request = LaunchRequest(file=str(path), **words)
    return evaluate(read_launch_file(path), {}, folder / "log", request)[0]


def loads(plan: LaunchPlan) -> Iterator[ComponentLoading]:
    for work in plan.start.works:
        assert isinstance(work, ComponentLoading)
        yield work


@given(WORDS, st.lists(COMPONENTS, max_size=3), st.lists(COMPONENTS, min_size=1, max_size=2))
def test_python_yaml_and_xml_load_the_same_into_a_container(pushed, inside, later):
    said = (pushed, inside, later)
    with TemporaryDirectory() as folder:
        plans = [
            planned(Path(folder), f"file.launch.{ending}", write(*said))
            for ending, write in (("py", as_python), ("yaml", as_yaml), ("xml", as_xml))
        ]
    first = plans[0]
    assert first.processes[0].node_name == f"/{pushed}/box"
    wanted = sum(each.get("if", True) for each in [*inside, *later])
    assert sum(len(work.components) for work in loads(first)) == wanted
    for other in plans[1:]:
        assert other.processes == first.processes
        assert other.start.files == first.start.files
        assert [(work.node_name, work.components) for work in loads(other)] == [
            (work.node_name, work.components) for work in loads(first)
        ]


def test_a_component_that_is_not_here_is_refused_before_anything_starts_or_left_out(tmp_path):
    text = """
        launch:
        - load_composable_node:
            target: /elsewhere
            composable_node: [{pkg: image_proc, plugin: "image_proc::RectifyNode"}]
        - node: {pkg: rclpy_components, exec: component_container, name: box}
        - load_composable_node:
            target: box
            composable_node:
            - {pkg: composition, plugin: "composition::Talker"}
            - {pkg: image_proc, plugin: "image_proc::RectifyNode"}
        """
    with pytest.raises(NotFoundError) as refused:
        planned(tmp_path, "a.launch.yaml", dedent(text))
    assert refused.value.message.startswith(
        f"{tmp_path}/a.launch.yaml:11: component image_proc::RectifyNode (package image_proc)"
    )
    plan = planned(tmp_path, "a.launch.yaml", dedent(text), skip_missing=True)
    assert [line for work in loads(plan) for line in work.describe()] == [
        # Of a container that is not of this launch nobody knows what it can load.
        "into /elsewhere: image_proc image_proc::RectifyNode",
        "into /box: composition composition::Talker",
    ]


@pytest.mark.parametrize("autostart", [True, False])
def test_a_lifecycle_node_of_a_text_is_a_node_that_is_activated_where_it_says_so(
    tmp_path, autostart
):
    node = "pkg: teleop_py_pkg, exec: simple_publisher, name: arm, namespace: left"
    text = f"launch:\n- lifecycle_node: {{{node}, autostart: {autostart}}}"
    plan = planned(tmp_path, "a.launch.yaml", text)
    assert [process.node_name for process in plan.processes] == ["/left/arm"]
    works = [work for work in plan.start.works if isinstance(work, CallSequence)]
    assert [work.node_name for work in works] == ["/left/arm"] * autostart
