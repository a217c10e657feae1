"""Conversion of an operator's commands to messages for servo, base, gripper and stop."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from teleopctl.interfaces import NANOSECONDS_PER_SECOND
from teleopctl.node import (
    SILENCE_S,
    Clock,
    ClockType,
    LeaseHolder,
    Node,
    StopButton,
    StopHolders,
)
from teleopctl.nodes.teleop.driven_robot import DrivenArm, DrivenRobot
from teleopctl.nodes.teleop.episode_buttons import EpisodeButtons
from teleopctl.nodes.teleop.hand_outputs import BaseOutput, ServoOutput, no_base
from teleopctl.nodes.teleop.stop_releaser import StopReleaser
from teleopctl.teleop import EPISODE, STALE_S, HandCommand
from teleopctl.tf import Transform

_PRESS_AGAIN = "another node drove when this was pressed: let go, and press again"
# Messages of standstill after a release: one may be lost.
_ZEROS = 3
# Period in which a handle's pose and the gripper's steps are sent, and in which a base is looked
# for, s.
_PERIOD_S, _LOOK_S = 0.02, 0.5
# Period while nothing is held and nothing moves, s.
_IDLE_S = 0.1
# Time after which a robot without a description is taken to be a base, s.
_LATE_S = 1.0
# Gap between samples, s, after which samples are ignored for a time, s, since they may have waited
# in a queue. A slow browser has shorter gaps.
_LONG_S, _IGNORED_S = 0.4, 0.25
# Time for which a command that comes again is published again without a new look at lease, gripper
# and stop, and for which servo and display are not looked at while it comes, s.
_REPEATED_S, _UNWATCHED_S = 0.1, 0.2
# Time for which a note is shown, s.
_NOTE_S = 5.0


class HandDriver:
    """Publishes an operator's commands, and monitors their effect.

    Without samples for `STALE_S` all inputs count as released; a release publishes 0 three times.
    After a longer gap, as when the device's process was suspended, samples are ignored for a time,
    since they may be old. If the gap lasted until the lease ended, or servo has ended, inputs must
    be released and pressed again: the robot does not move on its own when they come back.

    Args:
        node: Node of the endpoints; its executor must spin in another thread than `apply`'s.
        device: Name of the operator's device.
        servo: Name of the servo node.
        base: Topic of a mobile base's velocity, which is driven then; empty to drive an arm if
            the robot has one, else a base that subscribes to a topic ``cmd_vel``.

    Attributes:
        device: Name of the operator's device.
        robot_state: The robot.
        episodes: Buttons for episodes.
        on_action: Called with each action that begins and that the driver does not execute itself.
        on_watch: Called at least three times a second by the executor, without a timer of its own.
    """

    def __init__(self, node: Node, device: str, servo: str = "servo_node", base: str = "") -> None:
        self._node = node
        self.device = device
        servo = node.resolve_service_name(servo)
        self._lease = LeaseHolder(node, [servo], self._on_loss)
        self.robot_state = DrivenRobot(node, servo, drives_gripper=not base)
        self.episodes = EpisodeButtons(node)
        self.on_action: Callable[[str], object] = lambda _: None
        self.on_watch: Callable[[], object] = lambda: None
        self._servo = ServoOutput(node, servo, self.robot_state)
        self._base: BaseOutput | None = None
        self._base_topic = base
        self._looked_s = 0.0
        self._began_s = time.monotonic()
        # Whether another node has taken over since this one began to hold something.
        self._is_taken = False
        # Whether an input is held, also while samples are missing or commands refused.
        self._is_held = False
        self._refusal = ""
        # Whether another node drove when this one began to hold something.
        self._is_refused = False
        self._moved_s = 0.0
        self._lock = threading.Lock()
        self._target: Transform | None = None
        # Note, servo's own text for it, and the time until which it is shown, s.
        self._note = ("", "", 0.0)
        self._is_gripping = False
        self._speed = 1
        self._frame = "base"
        self._pressed: frozenset[str] = frozenset()
        self._has_toggled = False
        self._is_moving = False
        self._applied_s = 0.0
        # Command that is published again while the same object comes again, and until when, s.
        self._repeated: HandCommand | None = None
        self._repeated_until_s = 0.0
        self._watched_s = 0.0
        # Time of the first command since servo's newest status, s; None if it has answered.
        self._unanswered_since_s: float | None = None
        # Time until which samples are ignored after a gap, s.
        self._ignored_until_s = 0.0
        self._command = HandCommand()
        self._button = StopButton(node)
        self._stops = StopHolders(node, lambda _names: None)
        self._releaser = StopReleaser(node, self.note)
        self._timer = node.create_timer(
            _PERIOD_S, self._watch, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    # --- the robot --------------------------------------------------------------------------------

    @property
    def arm(self) -> DrivenArm | None:
        """The arm that is driven; None before its description is known."""
        return self.robot_state.arm

    @property
    def is_base(self) -> bool:
        """Whether a mobile base is driven."""
        return self._base is not None

    @property
    def is_stopped(self) -> bool:
        """Whether the robot is stopped on ``/stop``."""
        return bool(self._stops.names)

    @property
    def status(self) -> str:
        """Text of servo's status; empty if the motion is not slowed down."""
        return self.robot_state.status

    def tool(self) -> Transform | None:
        """Return the measured pose of the tool in the frame of the root link; None if unknown."""
        return self.robot_state.tool()

    @property
    def status_words(self) -> str:
        """Servo's status as one sentence for people; empty if the motion is not slowed down."""
        return self.robot_state.status_words

    def note(self, text: str, exact: str = "") -> None:
        """Display a note for some seconds.

        Args:
            text: The note.
            exact: Servo's own text for it.
        """
        self._note = (text, exact, time.monotonic() + _NOTE_S)

    @property
    def robot(self) -> str:
        """Name of the robot that is driven; empty before its description is known."""
        return self.robot_state.name

    # --- commands ---------------------------------------------------------------------------------

    def apply(self, command: HandCommand, speeds: tuple[float, ...]) -> None:
        """Publish a command; call it with each sample, from any one thread.

        Args:
            command: The operator's command.
            speeds: Speed steps of its mapping.
        """
        with self._lock:
            if self._repeat(command):
                return
            self._check_gap()
            if self._target is None or command.drags:
                self._applied_s = time.monotonic()
            others = [
                action
                for action in command.actions - self._pressed
                if not self._act(action, len(speeds))
            ]
            self._pressed = command.actions
            wants = command.is_held or command.toggles_gripper
            self._is_held = wants or self._target is not None
            if not self._may_move(wants=self._is_held):
                command = HandCommand(actions=command.actions)
            gripper = self.robot_state.gripper
            if command.toggles_gripper and not self._has_toggled and gripper is not None:
                gripper.toggle()
                self._hurry()
            self._has_toggled = command.toggles_gripper
            if "stop" in command.actions:
                command = HandCommand()
            self._command = command
            self._hold_gripper(command.gripper)
            if self._target is not None:
                pass  # the handle is held
            elif any(command.linear) or any(command.angular):
                part = command.part(speeds[min(self._speed, len(speeds) - 1)])
                if self._base is not None:
                    self._base.move(command, part)
                else:
                    self._servo.move(command, part, self._frame, begins=not self._is_moving)
                self._note_command()
                if not command.actions:
                    self._repeated = command
                    self._repeated_until_s = self._applied_s + _REPEATED_S
            elif self._is_moving:
                self._stop_moving()
        for action in others:
            self.on_action(action)

    def _repeat(self, command: HandCommand) -> bool:
        """Publish a command again if it is the last one; return whether it is done.

        A device gives the same command again and again while an input is held.
        """
        now_s = time.monotonic()
        if command is not self._repeated or now_s > self._repeated_until_s or not self._is_moving:
            self._repeated = None
            return False
        self._applied_s = self._moved_s = now_s
        output = self._servo if self._base is None else self._base
        output.repeat()
        return True

    def release(self) -> None:
        """Release all inputs: publish zero motion."""
        with self._lock:
            self._is_held, self._target = False, None
            self._is_taken, self._refusal, self._unanswered_since_s = False, "", None
            self._pause()

    def _pause(self) -> None:
        self._pressed, self._has_toggled = frozenset(), False
        self._command = HandCommand()
        self._hold_gripper(0.0)
        if self._is_moving:
            self._stop_moving()

    @property
    def is_pulled(self) -> bool:
        """Whether the tool moves to a pose of the device."""
        return self._target is not None

    def pull(self, target: Transform | None) -> str:
        """Move the tool to a pose while it is held; return why not, empty if it moves.

        Without a pose the hand lets go of what it moved by `pull` or `jog`.

        Args:
            target: Pose in the frame of the root link; None ends the motion.
        """
        with self._lock:
            self._repeated = None
            if target is None:
                self._target, self._is_held = None, False
                self._unanswered_since_s = None
                if self._is_moving:
                    self._stop_moving()
                return ""
            self._check_gap()
            if not self._may_move(wants=True) and self._refusal:
                return self._refusal
            self._target, self._is_held, self._applied_s = target, True, time.monotonic()
            self._send_target()
            self._hurry()
        return ""

    def _send_target(self) -> None:
        if self._target is None or self._applied_s < self._ignored_until_s:
            return
        self._servo.pull(self._target, begins=not self._is_moving)
        self._note_command()

    def jog(self, displacements: Mapping[str, float]) -> str:
        """Move joints by displacements; return why not, empty if they move.

        Args:
            displacements: Displacements by joint, rad or m; empty to hold the arm as it is.
        """
        with self._lock:
            self._repeated = None
            self._check_gap()
            may_move = self._may_move(wants=True)
            if not may_move and self._refusal:
                return self._refusal
            self._is_held, self._applied_s = True, time.monotonic()
            if displacements and may_move:
                self._servo.jog(displacements, begins=not self._is_moving)
                self._note_command()
        return ""

    def take_over(self) -> None:
        """Take the command lease, also from another node."""
        with self._lock:
            self._take()

    def _take(self) -> None:
        self._is_taken = False
        self._moved_s = time.monotonic()
        self._refusal = self._lease.take(self.device, by_force=True)

    def _may_move(self, *, wants: bool, holds: bool = True) -> bool:
        """Return whether this node may drive; take the lease at the beginning of a motion.

        Args:
            wants: Whether the robot is to move.
            holds: Whether by an input that is held, which after a refusal has to be released.
        """
        if not wants:
            self._unanswered_since_s = None
            self._is_taken = False
            self._refusal = ""
            return True
        self._lease.is_lost()
        if self._is_taken:
            if self._is_refused and self._lease.watch.holder is None:
                self._refusal = _PRESS_AGAIN
            return False
        self._refusal = self._lease.take(self.device)
        if self._refusal:
            # The end of another node's lease must not move the robot by what is still held.
            self._is_taken = self._is_refused = holds
            return False
        self._is_refused = False
        self._moved_s = time.monotonic()
        return self._moved_s >= self._ignored_until_s

    def _hurry(self) -> None:
        """Call `_watch` at its short period: it sends the handle's pose and the gripper's steps."""
        if self._timer.timer_period_ns != _ns(_PERIOD_S):
            self._timer.restart(_ns(_PERIOD_S))

    def _on_loss(self) -> None:
        # Only a new press moves the robot.
        self._is_taken = self._is_moving or self._is_gripping
        self._refusal = "another node has taken over" if self._is_taken else ""
        self._is_refused = False
        self._command = HandCommand()
        self._hold_gripper(0.0)
        self._target = None
        # Commands are refused meanwhile, and a message of standstill is harmless.
        self._is_moving = False

    def set_gripper(self, opening: float) -> None:
        """Move the gripper to an opening, from 0 (closed) to 1 (open)."""
        with self._lock:
            gripper = self.robot_state.gripper
            if gripper is not None and self._may_move(wants=True, holds=False):
                gripper.wanted = max(0.0, min(1.0, opening))
                self._hurry()

    def press_stop(self) -> None:
        """Stop the robot at once, on ``/stop``."""
        self.release()
        self._lease.release()
        self._button.press()

    def close(self) -> None:
        """Release all inputs, and end the lease."""
        self.release()
        self._lease.release()

    def release_stop(self) -> None:
        """Release the robot, also for the other nodes that hold it stopped."""
        self._button.release()
        own = self._node.get_fully_qualified_name()
        self._releaser.ask([name for name in self._stops.names if name != own])

    def _act(self, action: str, steps: int) -> bool:
        """Execute an action of a button; return whether the driver implements it."""
        if action in ("slower", "faster"):
            self._speed = max(0, min(steps - 1, self._speed + (1 if action == "faster" else -1)))
        elif action in ("base", "tip"):
            self._frame = action
        elif action == "stop":
            self._lease.release()
            self._button.press()
        elif action == "release_stop":
            self.release_stop()
        elif action == "take":
            self._take()
        elif action.startswith(EPISODE):
            self.episodes.press(action.removeprefix(EPISODE))
        else:
            return False
        return True

    def _stop_moving(self) -> None:
        for _ in range(_ZEROS):
            if self._base is not None:
                self._base.move(HandCommand(), 0.0)
            else:
                self._servo.halt()
        self._is_moving = False

    def _lose(self, reason: str) -> None:
        """Ignore the held inputs until they are released, and show the reason."""
        self._pause()
        self._target = self._unanswered_since_s = None
        self._is_held, self._is_taken, self._is_refused = False, True, False
        self._refusal = reason

    def _check_gap(self) -> None:
        """Ignore samples for a time, or until a release, if the gap before the newest was long."""
        now_s = time.monotonic()
        if self._is_held and now_s - self._applied_s > _LONG_S:
            self._ignored_until_s = now_s + _IGNORED_S
        self._lose_silent()

    def _lose_silent(self) -> None:
        if self._is_held and time.monotonic() - self._applied_s > SILENCE_S:
            self._lose("no input was received for a time: let go, and press again")

    def _note_command(self) -> None:
        """Record that a command was published."""
        if self._unanswered_since_s is None:
            self._unanswered_since_s = time.monotonic()
        self._is_moving = True

    def _servo_loss(self) -> str:
        """Return why servo does not move the arm any more: it has ended, or is silent for long."""
        self.robot_state.read_status()
        answered_s, since_s = self.robot_state.answered_s, self._unanswered_since_s
        if since_s is None or answered_s >= since_s:
            self._unanswered_since_s = None
        elif time.monotonic() - since_s > SILENCE_S:
            return "servo does not answer: let go, and press again"
        # A status that has just arrived spares the query of the graph.
        return self._servo.problem if time.monotonic() - answered_s > _IDLE_S else ""

    def _watch(self) -> None:
        """Release inputs without new samples, and continue the gripper's motion."""
        now_s = time.monotonic()
        silent_s = now_s - self._applied_s
        if (
            self._repeated is not None
            and silent_s < STALE_S
            and now_s - self._watched_s < _UNWATCHED_S
            and not (self._stops.names or self._has_gripper_steps())
        ):
            self._schedule_watch(silent_s)
            return
        self._watched_s = now_s
        self.robot_state.ask_servo()
        self.robot_state.forget_states()
        self._find_base()
        self._releaser.ask_again()
        with self._lock:
            self._lose_silent()
            silent_s = time.monotonic() - self._applied_s
            if self._is_moving and self._base is None and (problem := self._servo_loss()):
                self._lose(problem)
            elif (self._is_moving or self._is_gripping) and silent_s > STALE_S:
                self._pause()
            elif self._target is not None and silent_s <= STALE_S and not self._stops.names:
                # A handle that is held without motion has no new pose.
                if self._may_move(wants=True):
                    self._send_target()
                elif self._refusal:
                    self._target = None
            self._lease.is_lost()
            if self._stops.names or (
                not self._is_moving and time.monotonic() - self._moved_s > SILENCE_S
            ):
                self._lease.release()
            gripper = self.robot_state.gripper
            if gripper is not None and not gripper.is_done and not self._stops.names:
                gripper.step(_PERIOD_S, self.robot_state.measured)
            self._schedule_watch(silent_s)
        self.on_watch()

    def _has_gripper_steps(self) -> bool:
        gripper = self.robot_state.gripper
        return gripper is not None and (self._is_gripping or not gripper.is_done)

    def _schedule_watch(self, silent_s: float) -> None:
        """Schedule the next call of `_watch`, as late as it notices a silent device in time."""
        if self._target is not None or self._has_gripper_steps():
            period_s = _PERIOD_S
        elif self._is_moving:
            period_s = max(STALE_S - silent_s, _PERIOD_S)
        else:
            period_s = _IDLE_S
        if self._timer.timer_period_ns != _ns(period_s):
            self._timer.restart(_ns(period_s))

    def _find_base(self) -> None:
        """Search for a mobile base from time to time, while no arm is driven."""
        now_s, robot = time.monotonic(), self.robot_state
        if self._base is not None:
            if robot.arm is not None and not self._base_topic:
                self._base = None  # the description was late
            return
        has_no_arm = robot.arm is None and (robot.name or now_s - self._began_s > _LATE_S)
        if not (self._base_topic or has_no_arm) or now_s - self._looked_s < _LOOK_S:
            return
        self._looked_s = now_s
        self._base = BaseOutput.find(self._node, self._base_topic)
        if self._base is not None:
            self._node.get_logger().info(f"Drives the base by {self._base.topic}")

    def _hold_gripper(self, speed: float) -> None:
        """Move the gripper while a button is held: 1 opens, -1 closes, 0 is its release."""
        gripper = self.robot_state.gripper
        if gripper is None:
            return
        if speed:
            gripper.wanted = 1.0 if speed > 0.0 else 0.0
            self._hurry()
        elif self._is_gripping:
            gripper.halt()
        self._is_gripping = bool(speed)

    # --- what is shown ----------------------------------------------------------------------------

    # Any: values of a JSON document.
    def state(self, speeds: tuple[float, ...]) -> Mapping[str, Any]:
        """Return the state for the operator's display, as values for JSON.

        Args:
            speeds: Speed steps of the mapping.
        """
        command, robot, gripper = self._command, self.robot_state, self.robot_state.gripper
        part = command.part(speeds[min(self._speed, len(speeds) - 1)])
        scales = robot.scales if self._base is None else self._base.scales
        note, exact, until_s = self._note
        if time.monotonic() >= until_s:
            note = exact = ""
        problem = gripper.problem if gripper else ""
        return {
            "robot": self.robot,
            "kind": "arm" if self._base is None else "base",
            "turns": robot.arm is not None and robot.arm.turns,
            "has_gripper": gripper is not None,
            "problem": self.problem,
            "words": robot.status_words or problem,
            "status": robot.status or problem,
            "is_moving": self._is_moving,
            "linear": list(command.linear),
            "angular": list(command.angular),
            "speed": part,
            "speed_step": self._speed,
            "speed_m_s": part * scales["linear"],
            "speed_rad_s": part * scales["rotational"],
            "frame": self._frame,
            "stopped_by": list(self._stops.names),
            "note": note,
            "note_status": exact,
            "holder": self._holder(),
            "refusal": self._refusal,
            "episode": self.episodes.state(),
        }

    def openings(self) -> tuple[float | None, float | None]:
        """Return measured and wanted opening of the gripper, 0 to 1; None for what is unknown.

        Apart from `state`, since it subscribes to the joint states.
        """
        gripper = self.robot_state.gripper
        if gripper is None:
            return None, None
        robot = self.robot_state
        at = robot.measured if self._has_gripper_steps() else robot.glance()
        return gripper.opening(at), gripper.wanted

    @property
    def problem(self) -> str:
        """Reason why the robot cannot be driven; empty if it can."""
        if self._base is not None:
            return self._base.problem
        if self._base_topic:
            return no_base(self._base_topic)
        return self.robot_state.problem or self._servo.problem

    # Any: values of a JSON document.
    def _holder(self) -> Mapping[str, Any] | None:
        """Return the node that holds the command lease, for JSON; None if none does."""
        claim = self._lease.watch.holder
        if claim is None:
            return None
        return {
            "node": claim.holder,
            "device": claim.device,
            "host": claim.host,
            "since_ns": claim.since_ns,
            "is_this": self._lease.is_held,
        }


def _ns(seconds: float) -> int:
    return round(seconds * NANOSECONDS_PER_SECOND)
