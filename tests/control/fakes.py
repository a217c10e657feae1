"""Controllers that record calls and fail in a callback that a parameter names, and hardware."""

import threading

from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.hardware.base import HardwareComponentInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType

TYPE = "tests.control.fakes:Recorder"
CHAINABLE = "tests.control.fakes:Chainable"


class Recorder(ControllerInterface):
    """Controller that records its calls; the parameter ``failing`` sets a callback's result."""

    def __init__(self, params):
        super().__init__(params)
        self.calls = []
        self.periods = []
        self.failing = self.auto_declare("failing", ["", ""])
        self.shutdowns = 0

    def _do(self, name):
        self.calls.append(name)
        callback, outcome = self.failing
        if name != callback:
            return None
        if outcome == "raise":
            raise RuntimeError(f"{name} on purpose")
        return ReturnType[outcome] if name == "update" else CallbackReturn[outcome]

    def on_init(self):
        return self._do("init")

    def on_configure(self):
        return self._do("configure")

    def on_activate(self):
        return self._do("activate")

    def on_deactivate(self):
        return self._do("deactivate")

    def on_cleanup(self):
        return self._do("cleanup")

    def on_shutdown(self):
        return self._do("shutdown")

    def command_interface_configuration(self):
        return InterfaceConfiguration(
            InterfaceConfigurationType.INDIVIDUAL, self.auto_declare("commands", [])
        )

    def state_interface_configuration(self):
        return InterfaceConfiguration(
            InterfaceConfigurationType.INDIVIDUAL, self.auto_declare("states", [])
        )

    @property
    def updates(self):
        return len(self.periods)

    def update(self, time_ns, period):
        self.periods.append(period)
        return self._do("update")


class Follower(Recorder):
    """Controller that commands 100 times its number of updates; each update waits for ``gate``."""

    def __init__(self, params):
        super().__init__(params)
        self.threads = set()
        self.gate = threading.Event()
        self.gate.set()
        self.states = []

    def _command(self, value):
        for command in self.command_interfaces:
            command.value = value

    def on_activate(self):
        self._command(7.0)
        return super().on_activate()

    def on_deactivate(self):
        self._command(-7.0)
        return super().on_deactivate()

    def update(self, time_ns, period):
        self.threads.add(threading.current_thread().name)
        assert self.gate.wait(10.0)
        self.states.append([state.value for state in self.state_interfaces])
        outcome = super().update(time_ns, period)
        self._command(100.0 * self.updates)
        return outcome


FOLLOWER = "tests.control.fakes:Follower"


class Chainable(ChainableControllerInterface, Recorder):
    """Chainable controller that copies its references to its commands.

    The parameter ``exports`` lists the references. With the parameter ``sum`` the controller
    exports their sum as a state. The attribute ``topic`` replaces the value of a subscription.
    """

    def __init__(self, params):
        super().__init__(params)
        self.modes = []
        self.topic = None

    def on_export_reference_interfaces_list(self):
        self._do("export")
        exports: list[str] = self.auto_declare("exports", [])
        return [
            CommandInterface(f"{self.name}/{joint}".removesuffix("/"), name)
            for joint, _, name in (str(one).rpartition("/") for one in exports)
        ]

    def on_export_state_interfaces_list(self):
        return [StateInterface(self.name, "sum")] if self.auto_declare("sum", False) else []

    def on_set_chained_mode(self, chained_mode):
        self.modes.append(chained_mode)
        return not (chained_mode and self.auto_declare("loner", False))

    def update_reference_from_subscribers(self, time_ns, period):
        if self.topic is not None:
            for reference in self.reference_interfaces:
                reference.value = self.topic

    def update_and_write_commands(self, time_ns, period):
        self.periods.append(period)
        values = [reference.value for reference in self.reference_interfaces]
        for command, value in zip(self.command_interfaces, values, strict=False):
            command.value = value
        for state in self.exported_state_interfaces:
            state.value = sum(values)
        return self._do("update")

    def update(self, time_ns, period):
        return ChainableControllerInterface.update(self, time_ns, period)


class Broken(HardwareComponentInterface):
    """Hardware component whose constructor raises OSError."""

    def __init__(self, params):
        super().__init__(params)
        raise OSError("no such bus")


class RecorderHardware(HardwareComponentInterface):
    """Hardware that records its calls; ``outcomes`` has the results of reads and writes.

    Each read waits for ``gate``, adds 1 to the positions and releases ``has_read``; each write
    records the commands.
    """

    def __init__(self, params):
        super().__init__(params)
        self.calls = []
        self.reads = []
        self.writes = []
        self.written = []
        self.outcomes = {}
        self.threads = set()
        self.gate = threading.Event()
        self.gate.set()
        self.has_read = threading.Semaphore(0)

    def _do(self, name):
        self.calls.append(name)
        outcome = self.outcomes.get(name)
        if outcome == "raise":
            raise RuntimeError(f"{name} on purpose")
        return outcome

    def on_configure(self):
        return self._do("configure")

    def on_activate(self):
        return self._do("activate")

    def on_deactivate(self):
        return self._do("deactivate")

    def on_error(self):
        return self._do("error")

    def read(self, time_ns, period):
        self.reads.append(round(period, 9))
        self.threads.add(threading.current_thread().name)
        assert self.gate.wait(10.0)
        self.has_read.release()
        for state in self.state_interfaces.values():
            state.value += 1.0
        return self.outcomes.get("read")

    def write(self, time_ns, period):
        self.writes.append(round(period, 9))
        self.written.append([command.value for command in self.command_interfaces.values()])
        return self.outcomes.get("write")


class LockstepHardware(RecorderHardware):
    """Hardware whose states trigger the control cycles."""

    drives_cycle = True


HARDWARE = "tests.control.fakes:RecorderHardware"
LOCKSTEP = "tests.control.fakes:LockstepHardware"


def recorded_robot(*components, plugin=HARDWARE):
    """Return a URDF with one joint ``jointN`` for each component, by its attributes and tags.

    Args:
        components: Attributes of ``<ros2_control>``, tags in its ``<hardware>``, and further tags.
        plugin: Hardware component of all.
    """
    links = '<link name="link0"/>' + "".join(
        f'<link name="link{n}"/><joint name="joint{n}" type="continuous"><parent link="link0"/>'
        f'<child link="link{n}"/><axis xyz="0 0 1"/></joint>'
        for n in range(1, len(components) + 1)
    )
    control = "".join(
        f'<ros2_control name="H{n}" type="system" {attributes}><hardware>'
        f"<plugin>{plugin}</plugin>{tags}</hardware>{''.join(more)}"
        f'<joint name="joint{n}"><command_interface name="position"/>'
        '<state_interface name="position"><param name="initial_value">0</param></state_interface>'
        "</joint></ros2_control>"
        for n, (attributes, tags, *more) in enumerate(components, 1)
    )
    return f'<robot name="recorded">{links}{control}</robot>'


FAILURE, ERROR = CallbackReturn.FAILURE, CallbackReturn.ERROR
RETURN_ERROR = ReturnType.ERROR


def failing(callback, outcome):
    """Return the parameter ``failing`` for a `Recorder`: callback, and its result or ``raise``."""
    return [callback, outcome if outcome == "raise" else outcome.name]
