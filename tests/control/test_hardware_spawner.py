"""``hardware_spawner``: its command line, and the states to which it brings hardware."""

from typing import Any, cast

import pytest

from teleopctl.control.lifecycle import State
from teleopctl.control.services import ControllerManagerServices
from teleopctl.interfaces import get_service
from teleopctl.nodes.hardware_spawner import main, set_hardware_state
from teleopctl.testing import ControlStack, serial_robot


class Manager:
    """A manager in memory whose hardware is brought to states."""

    def __init__(self) -> None:
        self.stack = ControlStack(serial_robot())
        self.node = cast("Any", self.stack.node)
        (self.component,) = self.stack.resources.components.values()
        ControllerManagerServices(self.node, self.stack.manager)

    def call(self, service: str, kind: str, **fields: object) -> Any:
        types = get_service(f"controller_manager_msgs/srv/{kind}")
        return self.node.call(f"~/{service}", types.Request(**fields), types.Response())

    def spawn(self, action: str, name: str | None = None) -> tuple[bool, tuple[str, str], State]:
        """Bring a component to a state; return success, the last log line and the state."""
        log = self.stack.log
        log.lines.clear()
        client: Any = self
        ok = set_hardware_state(self.node, client, name or self.component.name, action)
        return ok, log.lines[-1], self.component.lifecycle_state


@pytest.fixture
def manager() -> Manager:
    return Manager()


def test_hardware_is_configured_and_activated_with_the_log_lines_of_ros_2(manager):
    name = manager.component.name
    for action, state in (("configured", State.INACTIVE), ("activated", State.ACTIVE)):
        message = f"lifecycle_msgs.msg.State(id={state.value}, label='{state.label}')"
        line = f"{action} component '{name}'. Hardware now in state: {message}."
        assert manager.spawn(action) == (True, ("info", line), state)


def test_unknown_hardware_is_reported_with_what_there_is(manager):
    ok, line, state = manager.spawn("configured", f"{manager.component.name}x")
    assert (ok, state) == (False, State.ACTIVE)
    assert line == (
        "warning",
        "Hardware Component is not loaded - state can not be changed. "
        f"Did you mean {manager.component.name}?",
    )


def test_hardware_that_refuses_is_reported_with_the_text_of_ros_2(manager):
    manager.spawn("configured")

    def refuse():
        raise RuntimeError("no power")

    manager.component.hardware.on_activate = refuse
    ok, line, state = manager.spawn("activated")
    assert (ok, state) != (True, State.ACTIVE)
    assert line[0] == "warning"
    assert line[1].startswith(f"Could not activated component '{manager.component.name}'. ")


@pytest.mark.parametrize("words", [["a"], ["--activate"], ["--activate", "--configure", "a"]])
def test_a_component_and_one_state_are_needed(words, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(words)
    assert stopped.value.code == 2
    assert "usage: hardware_spawner" in capsys.readouterr().err
