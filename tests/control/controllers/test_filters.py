"""Filters by their formulas, chains of filters, and the controller that exports filtered states."""

import math
from statistics import mean, median_low

import pytest
from hypothesis import given, strategies as st

from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.node import Parameter
from teleopctl.testing import ControlStack, serial_robot

TYPE = "chained_filter_controller/ChainedFilter"
VALUES = st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=12)
LOW_PASS = {"sampling_frequency": 1000.0, "damping_frequency": 20.5, "damping_intensity": 1.25}


def chain_of(*filters, prefix="filter_chain"):
    """The parameters of a chain of (type, parameters)."""
    return {
        f"{prefix}.filter{number}.{key}": value
        for number, (kind, params) in enumerate(filters, start=1)
        for key, value in {
            "name": f"number_{number}",
            "type": kind,
            **{f"params.{name}": value for name, value in params.items()},
        }.items()
    }


class Filtered:
    """A chained filter of the positions of two joints."""

    def __init__(self, parameters, inputs=("joint1/position",)):
        self.stack = ControlStack(serial_robot(2))
        options = {
            "input_interfaces": list(inputs),
            "output_interfaces": [f"{name}_filtered" for name in inputs],
            **parameters,
        }
        controller = self.stack.load_controller("filter", TYPE, options)
        assert isinstance(controller, ChainableControllerInterface)
        self.controller = controller
        self.node = self.stack.nodes["filter"]

    def outputs(self, *values):
        """The outputs after each update, while the first joint is at these positions."""
        found = []
        for value in values:
            self.stack.resources.state_interfaces["joint1/position"].value = value
            self.controller.update(0, 0.01)
            found.append(self.controller.exported_state_interfaces[0].value)
        return found


def filtered(values, kind, **params):
    """What a filter makes of values."""
    controller = Filtered(chain_of((kind, params)))
    controller.stack.activate("filter")
    return controller.outputs(*values)


def of_windows(values, length, function):
    return [function(values[max(0, n - length + 1) : n + 1]) for n in range(len(values))]


@given(values=VALUES, length=st.integers(1, 5))
def test_mean_and_median_are_those_of_the_last_values(values, length):
    means = filtered(values, "filters/MeanFilterDouble", number_of_observations=length)
    assert means == pytest.approx(of_windows(values, length, mean))
    medians = filtered(values, "filters/MedianFilterDouble", number_of_observations=length)
    assert medians == of_windows(values, length, median_low)


def test_a_low_pass_filter_has_the_step_response_of_its_formula():
    a = math.exp(-1 / 1000.0 * 2 * math.pi * 20.5 / 10 ** (1.25 / -10))
    found = filtered([0.0] + [1.0] * 5, "control_filters/LowPassFilterDouble", **LOW_PASS)
    # The step acts one update later.
    assert found == pytest.approx([0.0, 0.0, *(1 - a**n for n in range(1, 5))])


def test_a_low_pass_filter_starts_at_its_first_input():
    assert filtered([3.0, 3.0], "control_filters/LowPassFilterDouble", **LOW_PASS) == [3.0, 3.0]


@given(values=VALUES, alpha=st.floats(0.0, 1.0))
def test_an_exponential_filter_weighs_new_values_by_alpha(values, alpha):
    expected = [values[0]]
    for value in values[1:]:
        expected.append(alpha * value + (1.0 - alpha) * expected[-1])
    found = filtered(values, "control_filters/ExponentialFilterDouble", alpha=alpha)
    assert found == pytest.approx(expected, abs=1e-9)


@given(values=VALUES)
def test_a_transfer_function_is_its_difference_equation(values):
    b, a = [0.5, 0.25, 0.1], [2.0, -0.6, 0.3]
    found = filtered(values, "filters/TransferFunctionFilterDouble", a=a, b=b)
    for n, y in enumerate(found):
        past = sum(a[k] * found[n - k] for k in (1, 2) if k <= n)
        inputs = sum(b[k] * values[n - k] for k in (0, 1, 2) if k <= n)
        assert a[0] * y == pytest.approx(inputs - past, abs=1e-6)


@pytest.mark.parametrize(
    ("limits", "expected"),
    [
        ({"max_value": 2.0}, [0.0, 2.0, 2.0, -2.0]),
        ({"max_value": 2.0, "min_value": -1.0}, [0.0, 2.0, 2.0, -1.0]),
        ({"min_value": -1.0}, [0.0, 5.0, 5.0, -5.0]),
        ({"max_first_derivative_pos": 10.0}, [0.0, 1.0, 2.0, 1.0]),
        (
            {"max_first_derivative_pos": 10.0, "min_first_derivative_pos": -20.0},
            [0.0, 1.0, 2.0, 0.0],
        ),
        ({"max_second_derivative": 100.0}, [0.0, 1.0, 3.0, 4.0]),
    ],
)
def test_a_rate_limiter_limits_value_and_derivatives(limits, expected):
    inputs = [0.0, 5.0, 5.0, -5.0]
    kind = "control_filters/RateLimiterDouble"
    assert filtered(inputs, kind, sampling_interval=0.1, **limits) == pytest.approx(expected)


def test_a_rate_limiter_starts_at_its_first_input():
    kind = "control_filters/RateLimiterDouble"
    found = filtered([7.0, 7.0], kind, sampling_interval=0.1, max_first_derivative_pos=1.0)
    assert found == [7.0, 7.0]


def test_filters_work_one_after_the_other():
    controller = Filtered(
        chain_of(
            ("filters/MeanFilterDouble", {"number_of_observations": 2}),
            ("control_filters/RateLimiterDouble", {"sampling_interval": 1.0, "max_value": 3.0}),
        )
    )
    controller.stack.activate("filter")
    assert controller.outputs(1.0, 3.0, 9.0) == [1.0, 2.0, 3.0]


def test_another_controller_reads_the_filtered_state():
    controller = Filtered(chain_of(("filters/MeanFilterDouble", {"number_of_observations": 2})))
    controller.stack.activate("filter")
    name = "filter/joint1/position_filtered"
    controller.stack.load_controller(
        "states", "state_interfaces_broadcaster/StateInterfacesBroadcaster", {"interfaces": [name]}
    )
    controller.stack.activate("states")
    controller.stack.step()
    (message,) = controller.stack.nodes["states"].published("~/values")
    assert list(message.values) == [1.1]


def test_a_value_that_is_not_finite_leaves_the_output():
    controller = Filtered(chain_of(("filters/MeanFilterDouble", {"number_of_observations": 2})))
    controller.stack.activate("filter")
    assert controller.outputs(math.nan) == pytest.approx([math.nan], nan_ok=True)
    assert controller.outputs(2.0, math.inf, 4.0) == [2.0, 2.0, 3.0]


def test_an_activation_forgets_earlier_values():
    controller = Filtered(chain_of(("filters/MeanFilterDouble", {"number_of_observations": 2})))
    controller.stack.activate("filter")
    controller.outputs(2.0)
    controller.stack.deactivate("filter")
    controller.stack.activate("filter")
    assert controller.outputs(4.0) == [4.0]


def test_each_interface_may_have_a_chain_of_its_own():
    inputs = ("joint1/position", "joint2/position")
    lengths = {name: number for number, name in enumerate(inputs, start=1)}
    controller = Filtered(
        {
            key: value
            for name, length in lengths.items()
            for key, value in chain_of(
                ("filters/MeanFilterDouble", {"number_of_observations": length}),
                prefix=f"{name}.filter_chain",
            ).items()
        },
        inputs,
    )
    controller.stack.activate("filter")
    positions = controller.stack.resources.state_interfaces
    for value in (1.0, 3.0):
        for name in inputs:
            positions[name].value = value
        controller.controller.update(0, 0.01)
    found = [state.value for state in controller.controller.exported_state_interfaces]
    assert found == [3.0, 2.0]


def test_one_chain_may_be_that_of_all_interfaces():
    parameters = chain_of(("filters/MeanFilterDouble", {"number_of_observations": 2}))
    controller = Filtered(parameters, ("joint1/position", "joint2/position"))
    controller.stack.activate("filter")
    assert "Using global filter setting for all interfaces." in controller.node.log.texts("info")
    controller.outputs(2.0, 4.0)
    found = [state.value for state in controller.controller.exported_state_interfaces]
    assert found == [3.0, 2.1]


def test_a_changed_parameter_takes_effect_and_an_invalid_one_does_not():
    controller = Filtered(chain_of(("control_filters/ExponentialFilterDouble", {"alpha": 0.5})))
    controller.stack.activate("filter")
    name = "filter_chain.filter1.params.alpha"
    controller.outputs(0.0)
    controller.node.set_parameters([Parameter(name, value=0.25)])
    assert controller.outputs(1.0) == [0.25]
    controller.node.set_parameters([Parameter(name, value=7.0)])
    assert controller.outputs(1.0) == [0.4375]
    assert (
        "'filter_chain.filter1.params.alpha' with the value 7"
        in (controller.node.log.texts("error")[0])
    )


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({"filter_chain.filter1.name": "mean"}, "filter_chain.filter1.type are required"),
        (chain_of(("mean", {})), "mean must be of form <package_name>/<filter_name>"),
        (
            chain_of(("filters/Mean", {})),
            "the class filters/Mean with base class type filters::FilterBase<double> does not "
            "exist. Declared types are control_filters/ExponentialFilterDouble",
        ),
        (
            chain_of(("control_filters/LowPassFilterWrench", LOW_PASS)),
            "Could not load library for control_filters/LowPassFilterWrench",
        ),
        (
            chain_of(("filters/MeanFilterDouble", {})),
            "Could not configure number_1 of type filters/MeanFilterDouble: Parameter "
            "'filter_chain.filter1.params.number_of_observations' must be at least 1",
        ),
        (
            chain_of(("control_filters/LowPassFilterDouble", LOW_PASS | {"damping_frequency": 0})),
            "damping_frequency' with the value 0 must be greater than 0.0",
        ),
        (
            chain_of(("control_filters/LowPassFilterDouble", {"sampling_frequency": 1.0})),
            "damping_frequency' has no value",
        ),
        (
            chain_of(("filters/TransferFunctionFilterDouble", {"a": [0.0], "b": [1.0]})),
            "a[0] can not equal 0.",
        ),
        (
            chain_of(
                (
                    "control_filters/RateLimiterDouble",
                    {"sampling_interval": 1.0, "min_value": 1.0},
                )
            ),
            "min_value' with the value 1 must be less than or equal to 0.0",
        ),
    ],
)
def test_a_chain_that_cannot_be_made_is_refused(parameters, text):
    controller = Filtered(parameters)
    assert not controller.stack.manager.configure_controller("filter")
    assert text in controller.node.log.texts("fatal")[0]
    assert (
        "Failed to configure filter chain for interfaces" in (controller.node.log.texts("error")[0])
    )


def test_two_filters_of_one_name_are_refused():
    kind = ("filters/MeanFilterDouble", {"number_of_observations": 1})
    controller = Filtered(chain_of(kind, kind) | {"filter_chain.filter2.name": "number_1"})
    assert not controller.stack.manager.configure_controller("filter")
    assert controller.node.log.texts("fatal") == ["A filter with the name number_1 already exists"]


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({"input_interfaces": []}, "Parameter 'input_interfaces' cannot be empty"),
        ({"output_interfaces": ["a", "b"]}, "Input and output interfaces have to have the same"),
    ],
)
def test_wrong_interfaces_are_refused(parameters, text):
    controller = Filtered(parameters)
    assert not controller.stack.manager.configure_controller("filter")
    assert text in controller.node.log.texts("error")[0]
