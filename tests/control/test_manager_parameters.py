"""Parameters of the controller manager: names without effect, and ``handle_exceptions``."""

import re
from functools import partial
from typing import cast

import pytest

from teleopctl.control.controller_manager_node import end_with_exception, unread_manager_parameters
from teleopctl.control.in_memory.recorded_node import RecordedLog
from teleopctl.errors import HardwareError, InvalidParameterError, TeleopctlError
from teleopctl.node import RcutilsLogger
from teleopctl.testing import ControlStack, serial_robot
from tests.control.fakes import TYPE

READ = {"update_rate", "hardware_components_initial_state.inactive"}


def test_parameters_that_nothing_reads_are_named():
    given = ["update_rte", "use_sim_tme", "overruns.manage", "update_rate"]
    named = ["overruns.manage", "update_rte", "use_sim_tme"]
    assert unread_manager_parameters(given, READ) == named


def test_parameters_of_controllers_and_of_every_node_are_not():
    given = [
        "arm.type",
        "arm.gains.joint1.p",
        "diagnostics.threshold.controllers.periodicity.mean_error.warn",
        "use_sim_time",
        "hardware_components_initial_state.inactive",
        "defaults.switch_controller.strictness",
        "qos_overrides./joint_states.publisher.depth",
    ]
    assert unread_manager_parameters(given, READ) == []


# -- handle_exceptions ----------------------------------------------------------------------------

PLAIN = {"handle_exceptions": False}
HARDWARE = "tests.control.fakes:RecorderHardware"


def stack_without_handling(callback="", outcome="raise", **options):
    stack = ControlStack(serial_robot(**options), parameters=PLAIN)
    parameters = {"commands": ["joint1/position"], "failing": [callback, outcome]}
    return stack, partial(stack.load_controller, "own", TYPE, parameters)


@pytest.mark.parametrize("callback", ["init", "configure", "activate", "update", "deactivate"])
def test_an_exception_of_a_controller_is_raised(callback):
    stack, load = stack_without_handling(callback)
    with pytest.raises(RuntimeError, match=f"{callback} on purpose"):
        load()
        stack.activate("own")
        stack.step()
        stack.deactivate("own")


@pytest.mark.parametrize(
    "callback", ["read", "write", "on_configure", "prepare_command_mode_switch"]
)
def test_an_exception_of_hardware_is_raised(callback):
    stack, load = stack_without_handling(plugin=HARDWARE)
    (component,) = stack.resources.components.values()

    def fail(*_):
        raise OSError("the bus is gone")

    setattr(component.hardware, callback, fail)
    load()
    with pytest.raises(OSError, match="the bus is gone"):
        stack.activate("own")
        stack.step()
        component.change_state(component.lifecycle_state.UNCONFIGURED)
        component.change_state(component.lifecycle_state.INACTIVE)


def test_an_exception_of_a_hardwares_constructor_is_raised():
    with pytest.raises(OSError, match="no such bus"):
        ControlStack(serial_robot(plugin="tests.control.fakes:Broken"), parameters=PLAIN)


def test_a_callback_that_returns_an_error_deactivates_the_controller_as_ever():
    stack, load = stack_without_handling("update", "ERROR")
    load()
    stack.activate("own")
    stack.step()
    assert stack.manager.active_controllers == ()


def test_a_failure_that_is_foreseen_deactivates_or_refuses_as_ever():
    stack, load = stack_without_handling()
    controller = load()

    def refuse():
        raise InvalidParameterError("Parameter 'joints' is empty")

    controller.on_configure = refuse
    assert not stack.manager.configure_controller("own")


def test_the_process_ends_with_the_cause_and_the_log_has_the_traceback():
    log = RecordedLog("controller_manager")
    logger = cast(RcutilsLogger, log)
    failures: list[TeleopctlError] = []
    what = "Controller 'own' raised in update: ZeroDivisionError: division by zero (own.py:3)"
    try:
        1 / 0  # noqa: B018 - raises
    except ZeroDivisionError as error:
        cause = error
    end_with_exception(logger, failures.append, what, cause)
    end_with_exception(logger, failures.append, "Hardware 'h' …", HardwareError("no motor answers"))
    (failure,) = failures
    assert failure.message == what
    assert "handle_exceptions" in str(failure.hint)
    assert failure.__cause__ is cause
    (text,) = log.texts("fatal")
    assert re.fullmatch(r"Traceback .*1 / 0.*ZeroDivisionError: division by zero", text, re.DOTALL)
