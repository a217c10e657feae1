"""``rclpy_components``: a container and components that nobody here wrote, in one process."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from composition_interfaces.srv import ListNodes, LoadNode, UnloadNode
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy_components.component_manager import ComponentManager

from teleopctl.packages import find_component, list_components
from teleopctl.plugins import lookup
from teleopctl.testing import RosGraph
from tests.distributions import install
from tests.packages.prefix import write

STRANGERS = """
    import rclpy
    from rclpy.node import Node
    from std_msgs.msg import String


    class NamesItself(Node):
        def __init__(self):
            super().__init__("itself")
            self.speed = self.declare_parameter("speed", 1.0).value
            self.publisher = self.create_publisher(String, "words", 1)


    class TakesAName(Node):
        def __init__(self, node_name, **kwargs):
            super().__init__(node_name, **kwargs)


    class TakesEverything(Node):
        def __init__(self, name, *, context, cli_args, namespace, parameter_overrides,
                     use_global_arguments):
            super().__init__(
                name, context=context, cli_args=cli_args, namespace=namespace,
                parameter_overrides=parameter_overrides,
                use_global_arguments=use_global_arguments,
            )


    class HasANode:
        def __init__(self):
            self.inner = Node("inner")


    class Raises(Node):
        def __init__(self):
            super().__init__("half_made")
            raise OSError("no camera at /dev/video0")


    class Leaves(Node):
        def __init__(self):
            super().__init__("leaving")
            raise SystemExit(3)


    class NoNode:
        pass


    def make():
        return NamesItself()
"""
NAMES = "NamesItself TakesAName TakesEverything HasANode Raises Leaves NoNode make"

Load = Callable[..., Any]


@pytest.fixture
def strangers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """An installed distribution with components of every kind."""
    site = tmp_path / "site"
    monkeypatch.syspath_prepend(str(site))
    entries = {f"strangers::{name}": f"strangers_parts:{name}" for name in NAMES.split()}
    entries |= {"bare": "strangers_parts:NamesItself", "strangers::gone": "no_such_module:Gone"}
    install(site, "my-parts", {"rclpy_components": entries}, {"strangers_parts.py": STRANGERS})
    lookup.forget_entry_points()
    yield
    lookup.forget_entry_points()


@pytest.fixture
def manager(ros: RosGraph, strangers: None) -> Iterator[ComponentManager]:
    context = Context()
    context.init([])
    executor = SingleThreadedExecutor(context=context)
    manager = ComponentManager(executor, "box", context=context)
    yield manager
    manager.destroy_node()
    executor.shutdown()
    context.try_shutdown()


@pytest.fixture
def load(manager: ComponentManager) -> Load:
    def load(plugin: str, package: str = "strangers", **fields: Any) -> Any:
        request = LoadNode.Request(package_name=package, plugin_name=plugin, **fields)
        return manager.on_load_node(request, LoadNode.Response())

    return load


def listed(manager: ComponentManager) -> dict[int, str]:
    found = manager.on_list_node(ListNodes.Request(), ListNodes.Response())
    return dict(zip(found.unique_ids, found.full_node_names, strict=True))


@pytest.mark.parametrize(
    ("plugin", "name"),
    [
        ("strangers::NamesItself", "/itself"),
        ("strangers::TakesAName", "/takesaname"),
        ("strangers::TakesEverything", "/takeseverything"),
        ("strangers::HasANode", "/inner"),
        ("strangers::make", "/itself"),
        ("make", "/itself"),
    ],
)
def test_whatever_its_constructor_takes_a_component_has_the_name_it_is_given(
    manager, load, plugin, name
):
    assert load(plugin).full_node_name == name
    loaded = load(plugin, node_name="camera", node_namespace="/left")
    assert (loaded.success, loaded.unique_id) == (True, 2)
    assert loaded.full_node_name == "/left/camera"
    assert listed(manager) == {1: name, 2: "/left/camera"}


def test_parameters_remappings_and_options_reach_a_node_that_passes_nothing_on(manager, load):
    load(
        "strangers::NamesItself",
        node_name="camera",
        remap_rules=["words:=/said"],
        log_level=40,
        parameters=[Parameter("speed", value=2.5).to_parameter_msg()],
        extra_arguments=[
            Parameter("use_intra_process_comms", value=True).to_parameter_msg(),
            Parameter("start_parameter_services", value=False).to_parameter_msg(),
        ],
    )
    (node,) = [node for node in manager._shared.get_nodes() if node.get_name() == "camera"]
    assert node.speed == 2.5
    assert node.publisher.topic_name == "/said"
    assert node.get_logger().get_effective_level() == 40
    names = [name for name, _ in manager.get_service_names_and_types_by_node("camera", "/")]
    assert not any("parameter" in name for name in names)


@pytest.mark.parametrize(
    ("plugin", "reason"),
    [
        ("Raises", "Component constructor threw an exception: no camera at /dev/video0"),
        ("Leaves", "Component constructor threw an exception: 3"),
        ("NoNode", "Component constructor threw an exception: it has made no node"),
        ("gone", "Failed to load no_such_module:Gone: No module named 'no_such_module'"),
        ("other", "Failed to find class with the requested plugin name."),
    ],
)
def test_a_component_that_cannot_be_made_leaves_the_others_alone(manager, load, plugin, reason):
    load("strangers::NamesItself")
    failed = load(f"strangers::{plugin}")
    assert (failed.success, failed.error_message, failed.unique_id) == (False, reason, 0)
    assert listed(manager) == {1: "/itself"}
    names = set(manager.get_node_names())
    assert not names & {"half_made", "leaving"}
    assert load("strangers::NamesItself", node_name="b").unique_id == 2


def test_an_extra_argument_of_another_type_is_refused(load):
    text = Parameter("use_intra_process_comms", value="yes").to_parameter_msg()
    failed = load("strangers::NamesItself", extra_arguments=[text])
    assert failed.error_message == (
        "Extra component argument 'use_intra_process_comms' must be a boolean"
    )


def test_what_is_unloaded_is_gone_and_its_number_is_not_given_again(manager, load):
    load("strangers::NamesItself")

    def unload(number: int) -> Any:
        request = UnloadNode.Request(unique_id=number)
        return manager.on_unload_node(request, UnloadNode.Response())

    assert unload(1).success
    assert listed(manager) == {}
    assert manager.get_node_names() == ["box"]
    assert unload(1).error_message == "No node found with unique_id: 1"
    assert load("strangers::NamesItself").unique_id == 2


def test_a_package_without_components_is_refused_in_the_words_of_ros(load):
    failed = load("strangers::NamesItself", package="stranger")
    assert failed.error_message == "Could not find requested resource in ament index"


def test_components_are_found_by_the_package_that_brings_them(strangers):
    assert find_component("my_parts", "bare").target == "strangers_parts:NamesItself"
    assert [each.type_name for each in list_components()["my-parts"]] == ["bare"]
    assert find_component("composition", "composition::Talker").package == "composition"


def test_a_package_that_is_not_built_has_its_components_too(tmp_path, monkeypatch):
    folder = tmp_path / "ws/src/eyes"
    write(folder / "package.xml", "<package><name>eyes</name></package>")
    write(
        folder / "setup.py",
        "from setuptools import setup\nname = 'eyes'\nsetup(name=name, entry_points={\n"
        "  'rclpy_components': [name + '::Camera = eyes.camera:Camera',\n"
        "                       'seeing::Lens = eyes.lens:Lens']})\n",
    )
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", str(tmp_path / "ws"))
    found = find_component("eyes", "eyes::Camera")
    assert (found.target, found.import_roots) == ("eyes.camera:Camera", (folder,))
    for package in ("eyes", "seeing"):
        assert find_component(package, "seeing::Lens").target == "eyes.lens:Lens"


def test_every_component_of_ours_is_there():
    for components in list_components().values():
        for component in components:
            module, _, name = component.target.partition(":")
            assert isinstance(getattr(__import__(module, fromlist=[name]), name), type)
