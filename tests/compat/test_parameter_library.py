"""Modules of generate_parameter_library, made of their YAML files when they are imported."""

import sys

import pytest
from generate_parameter_library_py.parameters import namespace_of
from rclpy.exceptions import InvalidParameterValueException
from rclpy.parameter import Parameter

from teleopctl.errors import InvalidFileError
from teleopctl.node import Context, Node, SignalHandlerOptions

YAML = """
my_arm:
  rate: {type: double, default_value: 10, description: in Hz, validation: {gt<>: [0.0]}}
  mode:
    type: string
    default_value: spline
    validation: {one_of<>: [[spline, linear]], "custom_validators::no_spaces": null}
  joints: {type: string_array, default_value: [a, b], validation: {not_empty<>: null}}
  size: {type: int, default_value: 3, read_only: true, validation: {bounds<>: [1, 5]}}
  tool:
    frame: {type: string_fixed_25}
    speeds: {type: double_array_fixed_3, default_value: [1, 2], validation: {size_lt<>: 3}}
  gains:
    __map_joints:
      p: {type: double, default_value: 1.0}
      limit:
        upper: {type: double, default_value: 2.0, validation: {lt_eq<>: [4.0]}}
"""
CHECKS = "def no_spaces(param):\n    return 'no spaces!' if ' ' in param.value else ''\n"
SETUP = """
from setuptools import setup
name = "arm_parameters"
if True:
    generate_parameter_module(name, "arm_pkg/arm.yaml", validation_module="arm_pkg.checks")
setup(name="arm_pkg")
"""
CMAKE = """
project(arm_pkg)
generate_parameter_module(arm_parameters  # the module
  arm_pkg/arm.yaml ${PROJECT_NAME}.checks)
"""


@pytest.fixture(params=[("setup.py", SETUP), ("CMakeLists.txt", CMAKE)])
def my_arm(tmp_path, monkeypatch, request):
    """The class of the file, imported as a program does from a package that is not built."""
    script, text = request.param
    package = tmp_path / "arm_pkg"
    package.mkdir()
    for name, content in (("__init__.py", ""), ("arm.yaml", YAML), ("checks.py", CHECKS)):
        (package / name).write_text(content)
    (tmp_path / "package.xml").write_text("<package><name>arm_pkg</name></package>")
    (tmp_path / script).write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    yield __import__("arm_pkg.arm_parameters").arm_parameters.my_arm
    for name in [name for name in sys.modules if name.startswith("arm_pkg")]:
        del sys.modules[name]


@pytest.fixture
def make_node(tmp_path):
    with Context() as context:
        context.try_shutdown()
        context.init([], signal_handler_options=SignalHandlerOptions.NO)
        made = []

        def make(**values):
            given = {"tool.frame": "tip", **values}
            overrides = [Parameter(name, value=value) for name, value in given.items()]
            made.append(Node("arm", context=context, parameter_overrides=overrides))
            return made[-1]

        yield make
        for node in made:
            node.destroy_node()


def test_parameters_are_declared_and_followed(my_arm, make_node):
    node = make_node(**{"gains.b.p": 5.0})
    listener = my_arm.ParamListener(node)
    params = listener.get_params()
    assert (params.rate, params.mode, params.tool.frame, params.tool.speeds) == (
        10.0,
        "spline",
        "tip",
        [1.0, 2.0],
    )
    assert [params.gains.get_entry(name).p for name in "ab"] == [1.0, 5.0]
    assert params.gains.get_entry("a").limit.upper == 2.0
    described = node.describe_parameter("rate")
    assert described.description == "in Hz"
    assert described.floating_point_range[0].from_value > 0.0
    assert node.describe_parameter("size").read_only
    seen = []
    listener.set_user_callback(lambda new: seen.append(new.mode))
    assert not listener.is_old(params)
    assert node.set_parameters([Parameter("mode", value="linear")])[0].successful
    assert listener.is_old(params)
    assert (listener.get_params().mode, seen) == ("linear", ["linear"])
    (refused,) = node.set_parameters([Parameter("mode", value="cubic")])
    assert "is not in the set ['spline', 'linear']" in refused.reason
    (refused,) = node.set_parameters([Parameter("gains.a.limit.upper", value=9.0)])
    assert not refused.successful
    listener.set_params_from_dict({"gains": {"a": {"p": 7.0}}})
    assert listener.get_params().gains.get_entry("a").p == 7.0
    node.set_parameters([Parameter("joints", value=["a", "c"])])
    listener.refresh_dynamic_parameters()
    assert node.get_parameter("gains.c.p").value == 1.0


def test_an_invalid_override_is_refused(my_arm, make_node):
    with pytest.raises(InvalidParameterValueException, match=r"no spaces|is not in the set"):
        my_arm.ParamListener(make_node(mode="a b"))


def test_values_are_there_without_a_node(my_arm):
    params = my_arm.Params()
    assert (params.rate, params.tool.frame) == (10, None)


@pytest.mark.parametrize("text", ["[1]", "a: {}\nb: {}", "a: [", "a: {b: {type: complex}}"])
def test_a_file_that_is_none_is_refused(tmp_path, text, make_node):
    file = tmp_path / "bad.yaml"
    file.write_text(text)
    with pytest.raises(InvalidFileError):
        vars(namespace_of(file)[1])["ParamListener"](make_node())
