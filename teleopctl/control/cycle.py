"""Control cycle, and the loop that runs it on the wall clock.

In lockstep this loop does not run: the hardware calls ``Cycle.run`` for each received state.
"""

from __future__ import annotations

import gc
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from teleopctl.base.exception_origin import with_origin
from teleopctl.control.asynchronous.scheduling import schedule_control_loop
from teleopctl.control.controller_manager import ControllerManager
from teleopctl.control.controller_spec import ControllerSpec
from teleopctl.control.hardware_component import HardwareComponent
from teleopctl.control.lifecycle import ReturnType, State
from teleopctl.control.realtime_publisher import PublishQueue
from teleopctl.control.robot_stop import StopRamp
from teleopctl.control.statistics import CycleTimes
from teleopctl.control.switching import start_fallbacks
from teleopctl.interfaces import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    from teleopctl.control.controllers.base import ControllerInterface
    from teleopctl.node import RcutilsLogger

# Number of new objects from which garbage is collected in the slack of a cycle.
_GARBAGE = 2000
# Number of new objects from which garbage is collected even without slack, to bound memory.
_MUCH_GARBAGE = 200_000
_STOP_ON_DEACTIVATE = "defaults.deactivate_controllers_on_hardware_self_deactivate"
# Longest time for which `stop` may have to wait for the sleeping loop, in seconds.
_LONGEST_SLEEP_S = 0.02
# Seconds between two reports of the same kind from the loop.
_REPORT_PERIOD = 1.0
# After this time without a cycle, in seconds and in last periods, controllers restart from the
# positions of the joints: a trajectory that continued would jump.
_STANDSTILL_S = 1.0
_STANDSTILL_PERIODS = 3


class Cycle:
    """Control cycle: reads hardware, updates controllers, enforces limits, writes hardware.

    Args:
        manager: Controller manager with the controllers and the hardware.
        publish_queue: Queue that controllers publish through.

    Attributes:
        time_ns: Time of the last cycle in nanoseconds; 0 before the first cycle.
        began_s: Begin of the running cycle, on the monotonic clock in seconds; 0 between cycles.
        running: Name of the controller whose method runs in the cycle, empty for that of hardware,
            and the method's name.
        times: Durations of the cycles and their parts, and errors of their period.
        missed_count: Number of cycles that the loop on the wall clock has missed, as it logs them.
        on_written: Function called in each cycle after the hardware is written, or None.
    """

    def __init__(self, manager: ControllerManager, publish_queue: PublishQueue) -> None:
        self._manager = manager
        self._publish_queue = publish_queue
        self._nominal_ns = round(NANOSECONDS_PER_SECOND / manager.update_rate)
        self._standstill_ns = round(_STANDSTILL_S * NANOSECONDS_PER_SECOND)
        self._last_period_ns = self._nominal_ns
        self._reports: deque[str] = deque(maxlen=100)
        self._changed = False
        # Why controllers were restarted in this cycle.
        self._restarted = ""
        self._trigger_ns: int | None = None
        # Of the controllers that decelerate or stand, while the robot is stopped.
        self._stop_ramps: dict[ControllerInterface, StopRamp] = {}
        self.time_ns = 0
        self.began_s = 0.0
        self.running = ("", "read")
        self.times = CycleTimes(self._nominal_ns)
        self.missed_count = 0
        self.on_written: Callable[[], None] | None = None

    def what_runs(self) -> tuple[str, str]:
        """Return the controller or hardware whose method runs, in words, and the method's name."""
        controller, function = self.running
        if controller:
            return f"Controller '{controller}'", function
        return f"Hardware '{self._manager.resource_manager.in_use}'", function

    def stand_still(self, reason: str) -> None:
        """Abort all goals, and refuse goals and commands until a cycle begins again.

        Not for the thread of the cycle, which may hang.

        Args:
            reason: Why no cycle begins.
        """
        stop = self._manager.robot_stop
        stop.stand_still(reason)
        for spec in self._manager.active_controllers:
            try:
                spec.controller.abort_goals(stop.reason)
            except (Exception, SystemExit) as error:  # noqa: BLE001 - one controller must not keep the goals of others
                self._report_raised(spec, "abort_goals", error)

    def report(self, sentence: str) -> None:
        """Store a warning that is logged after the present cycle."""
        self._reports.append(sentence)

    def run(self, time_ns: int, steady_ns: int | None = None) -> None:
        """Run one control cycle at a given time, then publish queued values and log warnings.

        Args:
            time_ns: Time of the cycle in nanoseconds, for controllers and stamps.
            steady_ns: The same time on the clock that triggers the cycles; by default ``time_ns``.
                The period is the time on this clock since the last cycle; the nominal period in
                the first cycle and after a jump back.
        """
        manager, resources = self._manager, self._manager.resource_manager
        trigger_ns = time_ns if steady_ns is None else steady_ns
        with manager.cycle_lock:
            last_ns, self._trigger_ns = self._trigger_ns, trigger_ns
            period_ns = self._nominal_ns if last_ns is None else trigger_ns - last_ns
            jumped = period_ns <= 0
            stop = manager.robot_stop
            # States may come at a lower rate than the update rate.
            usual_ns, self._last_period_ns = self._last_period_ns, max(period_ns, self._nominal_ns)
            stood_still = bool(stop.standstill) or (
                period_ns >= self._standstill_ns and period_ns >= _STANDSTILL_PERIODS * usual_ns
            )
            if stood_still and not stop.standstill:
                stop.stand_still(f"no cycle began for {period_ns / NANOSECONDS_PER_SECOND:.1f} s")
            if jumped or stood_still:
                period_ns = self._nominal_ns
            self.time_ns = time_ns
            period = period_ns / NANOSECONDS_PER_SECOND
            began_ns = time.perf_counter_ns()
            self.running = ("", "read")
            self.began_s = time.monotonic()
            for component in resources.read(time_ns, period):
                self._component_failed(component, "read")
            was_reset = resources.take_state_jumped()
            if was_reset or jumped or stood_still:
                if stood_still:
                    self._forget_last_updates()
                # In lockstep, the simulator may be another one.
                self._restart(jumped=resources.in_lockstep or not stood_still)
                self._restarted = stop.standstill or (
                    "the simulation was reset" if was_reset else "time jumped back"
                )
                stop.stand_still("")
            stop.estimate_speeds(resources.state_interfaces, period)
            if stop.by or self._stop_ramps:
                self._apply_stop()
            read_ns = time.perf_counter_ns()
            self._update(time_ns, trigger_ns, period_ns)
            resources.enforce_command_limits(period)
            updated_ns = time.perf_counter_ns()
            self.running = ("", "write")
            for component in resources.write(time_ns, period):
                self._component_failed(component, "write")
            if self.on_written is not None:
                self.on_written()
            self.times.record(began_ns, read_ns, updated_ns, None if last_ns is None else period_ns)
            self.began_s = 0.0
        if not manager.first_cycle.is_set():
            manager.first_cycle.set()
        self._publish_queue.flush()
        if self._restarted:
            self._report_restart()
        while self._reports:
            manager.logger.warning(self._reports.popleft())
        if self._changed:
            self._changed = False
            manager.node.publish_activity()

    def _forget_last_updates(self) -> None:
        """Exclude a time without cycles from the update periods of controllers."""
        for spec in self._manager.active_controllers:
            spec.last_update_cycle_time_ns = None

    def _report_restart(self) -> None:
        """Log why controllers with commands were restarted."""
        cause, self._restarted = self._restarted, ""
        if any(spec.required_command_interfaces for spec in self._manager.active_controllers):
            self._manager.logger.info(
                f"Controllers go on from where the joints are, without their goals: {cause}"
            )

    def _restart(self, *, jumped: bool) -> None:
        """Restart active controllers.

        Args:
            jumped: Whether the joints have jumped; otherwise hardware keeps its last commands.
        """
        if jumped:
            self._manager.resource_manager.restart()
        self._manager.robot_stop.forget_speeds()
        # The controllers stop again, from where the joints are now.
        self._stop_ramps.clear()
        for spec in self._manager.active_controllers:
            self.running = (spec.name, "on_restart")
            if spec.async_update is not None:
                spec.async_update.restart()
            try:
                spec.controller.on_restart()
            except (Exception, SystemExit) as error:  # noqa: BLE001 - one controller must not stop the others
                self._report_raised(spec, "on_restart", error)

    def _apply_stop(self) -> None:
        """Call ``on_stop`` of active controllers, or ``on_release`` of those that are stopped."""
        manager, ramps = self._manager, self._stop_ramps
        stop = manager.robot_stop
        for spec in manager.active_controllers:
            controller = spec.controller
            if not spec.required_command_interfaces or stop.is_stopped is (controller in ramps):
                continue
            change = controller.on_stop if stop.is_stopped else controller.on_release
            self.running = (spec.name, change.__name__)
            if spec.async_update is not None:
                spec.async_update.pause_in_cycle()
            try:
                change()
                commands = controller.interfaces_to_decelerate()
            except (Exception, SystemExit) as error:  # noqa: BLE001 - one controller must not keep the others from stopping
                self._report_raised(spec, change.__name__, error)
                commands = controller.command_interfaces
            if spec.async_update is not None:
                # Its updates are paused: it cannot decelerate the joints itself.
                commands = spec.async_update.shared(controller.command_interfaces)
                if not stop.is_stopped:
                    spec.async_update.resume()
            if stop.is_stopped:
                states = manager.resource_manager.state_interfaces
                ramps[controller] = StopRamp(
                    commands, states, stop, step_age_s=controller.seconds_since_step
                )
        active = {spec.controller for spec in manager.active_controllers}
        for controller in [one for one in ramps if one not in active or not stop.is_stopped]:
            del ramps[controller]

    def _report_raised(self, spec: ControllerSpec, function: str, error: BaseException) -> None:
        sentence = f"Controller '{spec.name}' raised in {function}: {with_origin(error)}"
        self.report(sentence)
        self._manager.resource_manager.on_exception(sentence, error)

    def _update(self, time_ns: int, trigger_ns: int, period_ns: int) -> None:
        failed: list[ControllerSpec] | None = None
        ramps = self._stop_ramps
        for spec in self._manager.active_controllers:
            controller, async_update = spec.controller, spec.async_update
            if async_update is not None and controller not in ramps:
                async_update.hand_over()
            nominal_ns = round(NANOSECONDS_PER_SECOND / controller.update_rate)
            last_ns = spec.last_update_cycle_time_ns
            since_ns = nominal_ns
            if last_ns is not None and last_ns < trigger_ns:
                since_ns = trigger_ns - last_ns
            if nominal_ns > self._nominal_ns and (
                # True if the next cycle is nearer to the time at which the controller is due.
                abs(since_ns - nominal_ns) > abs(since_ns + period_ns - nominal_ns)
            ):
                if ramps and controller in ramps:
                    ramps[controller].apply(period_ns / NANOSECONDS_PER_SECOND)
                continue
            spec.last_update_cycle_time_ns = trigger_ns
            self.running = (spec.name, "update")
            since = since_ns / NANOSECONDS_PER_SECOND
            began_ns = time.perf_counter_ns()
            try:
                if async_update is None:
                    outcome = controller.update(time_ns, since)
                else:
                    outcome = async_update.trigger(time_ns, since)
            except (Exception, SystemExit) as error:  # noqa: BLE001 - one controller must not stop the others
                self._report_raised(spec, "update", error)
                outcome = ReturnType.ERROR
            if ramps and controller in ramps:
                ramps[controller].apply(period_ns / NANOSECONDS_PER_SECOND)
            if async_update is None:
                spec.statistics.add(began_ns, None if last_ns is None else since)
            if outcome is not None and outcome is not ReturnType.OK:
                failed = [*(failed or ()), spec]
        if failed is not None:
            failed = self._manager.chains.connected(failed)
            names = " ".join(spec.name for spec in failed)
            self._manager.logger.error(
                f"Deactivating controllers : [ {names} ] as their update resulted in an error!"
            )
            self.running = (names, "on_deactivate")
            self._manager.stop_controllers(failed)
            start_fallbacks(self._manager, failed)
            self._changed = True

    def _component_failed(self, component: HardwareComponent, operation: str) -> None:
        withdrew = component.lifecycle_state is State.INACTIVE
        if withdrew and self._manager.node.parameter(_STOP_ON_DEACTIVATE) is False:
            self._manager.logger.error(
                f"'{component.name}' is now inactive; its controllers keep running, since "
                f"{_STOP_ON_DEACTIVATE} is false"
            )
            self._changed = True
            return
        users = self._manager.chains.connected(
            self._manager.users_of(component, only_commands=withdrew)
        )
        names = " ".join(spec.name for spec in users)
        self._manager.logger.error(
            f"Deactivating following controllers as their hardware components {operation} cycle "
            f"resulted in an error: [ {names} ] ('{component.name}' is now "
            f"{component.lifecycle_state.label})"
        )
        self.running = (names, "on_deactivate")
        self._manager.stop_controllers(users)
        self._changed = True


class WallClockLoop:
    """Thread that runs the control cycle at the update rate on the wall clock.

    Args:
        cycle: Control cycle to run.
        update_rate: Update rate in Hz.
        logger: Logger for warnings about missed cycles.
        print_warnings: Whether missed cycles are logged.
    """

    def __init__(
        self, cycle: Cycle, update_rate: int, logger: RcutilsLogger, *, print_warnings: bool = True
    ) -> None:
        self._cycle = cycle
        self._rate = update_rate
        self._logger = logger
        self._print_warnings = print_warnings
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="control loop", daemon=True)
        self._last_report = 0.0
        self._last_failure = 0.0

    def start(self) -> None:
        """Start the thread of the loop."""
        self._thread.start()

    def stop(self) -> None:
        """End the loop after the present cycle, and wait up to 2 s for the thread."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(timeout=2.0)

    def _run(self) -> None:
        schedule_control_loop(self._logger)
        period = 1.0 / self._rate
        deadline = time.monotonic()
        # Garbage is collected in the slack after a cycle, never within a cycle.
        gc.collect()
        gc.freeze()
        gc.disable()
        try:
            while not self._stop.is_set():
                self._run_cycle()
                deadline += period
                slack = deadline - time.monotonic()
                if slack < 0.0:
                    # The late cycle runs at once; the deadline after it is on the grid again.
                    late = int(-slack / period)
                    self._cycle.missed_count += late + 1
                    self._report_overrun(period - slack, late + 1)
                    deadline += late * period
                    slack = deadline - time.monotonic()
                garbage = gc.get_count()[0]
                if garbage > (_GARBAGE if slack > period / 2 else _MUCH_GARBAGE):
                    # Cheap: objects from before the start of the loop are frozen and skipped.
                    gc.collect()
                    slack = deadline - time.monotonic()
                if slack > _LONGEST_SLEEP_S:
                    self._stop.wait(slack - _LONGEST_SLEEP_S)
                    slack = deadline - time.monotonic()
                if slack > 0.0:
                    time.sleep(slack)
        finally:
            gc.enable()

    def _run_cycle(self) -> None:
        try:
            # The system's clock may be set at any time, so periods are on the monotonic clock.
            self._cycle.run(time.time_ns(), time.monotonic_ns())
        except (Exception, SystemExit) as error:  # noqa: BLE001 - the robot would be without control
            now = time.monotonic()
            if now - self._last_failure >= _REPORT_PERIOD:
                self._last_failure = now
                self._logger.error(f"The control cycle failed: {with_origin(error)}")

    def _report_overrun(self, took: float, missed: int) -> None:
        now = time.monotonic()
        if not self._print_warnings or now - self._last_report < _REPORT_PERIOD:
            return
        self._last_report = now
        self._logger.warning(
            "Overrun detected! The controller manager missed its desired rate of "
            f"{self._rate} Hz. The loop took {took * 1e3:.3f} ms (missed cycles : {missed})."
        )
