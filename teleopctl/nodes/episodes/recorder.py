"""Executable ``episode_recorder``: records episodes as bags, and adds them to a data set.

Services (``std_srvs/srv/Trigger``): ``~/start``, ``~/save``, ``~/discard``, and ``~/success``,
which marks the running episode as successful. ``~/state`` (latched,
``diagnostic_msgs/msg/DiagnosticStatus``) says what the recorder does. In a terminal, keys do the
same as the services.

Parameters: ``folder``; ``task``; ``fps``; ``robot``, one word; ``episodes``, after which the
program ends, 0 for no limit; ``episode_time``, seconds after which an episode is saved, 0 for no
limit; ``state``, ``action``, ``cameras``, ``hand`` and ``driven_by``, see `EpisodeSettings`;
``raw_images``, whether to record images uncompressed; ``record.exclude_regex``; and for a
simulation ``reset``, whether each episode begins with a reset, with ``reset.position`` (m) and
``reset.yaw`` (rad), the largest displacements of the free objects, by ``seed`` and number of the
episode.

A saved episode is added to the data set by a process of its own, while the next one is recorded.
"""

from __future__ import annotations

import contextlib
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from teleopctl.bag import (
    EPISODE_RECORD,
    STATE_ATTACHMENT,
    BagAttachment,
    EpisodeFolder,
    EpisodeSettings,
    PauseGate,
    RecorderOptions,
    RecordingSession,
    Selection,
)
from teleopctl.base import progress
from teleopctl.base.keyboard import LEFT, RIGHT, SPACE, Keyboard, keys_can_be_read
from teleopctl.errors import (
    InvalidParameterError,
    RefusedError,
    SystemFailureError,
    TeleopctlError,
)
from teleopctl.interfaces import get_message, get_service
from teleopctl.node import (
    ExternalShutdownException,
    LeaseWatch,
    MultiThreadedExecutor,
    MutuallyExclusiveCallbackGroup,
    Node,
    Parameter,
    init,
    qos_profile_latched,
    spin_in_thread,
)
from teleopctl.nodes.episodes.fitting import EpisodeFitting, missing_topics
from teleopctl.nodes.episodes.growth import DataSetGrowth
from teleopctl.nodes.episodes.simulation import EpisodeSimulation

# Any, here and below: message classes are generated at run time from definitions.

# Hidden topics, and figures of the programs' own work, are of no use in an episode.
_NOT_RECORDED = (
    r"/_|/introspection_data/|/statistics/|^/performance_metrics$|^/diagnostics$|/compressedDepth$"
)

IDLE, RECORDING, FAILED = "idle", "recording", "failed"
"""Messages of ``~/state``."""

_KEYS = """\
space  begins an episode, and saves it      right arrow  saves it as a success
left arrow  discards it                     q or Ctrl-C  ends
"""


class EpisodeRecorder(Node):
    """Node that records episodes."""

    def __init__(self, *, parameters: Sequence[Parameter] = ()) -> None:
        super().__init__("episode_recorder", parameter_overrides=list(parameters))
        defaults: dict[str, bool | int | float | str] = {
            "folder": "",
            "task": "teleoperation",
            "fps": 30,
            "robot": "",
            "episodes": 0,
            "episode_time": 0.0,
            "state": "/joint_states",
            "hand": "",
            "driven_by": "",
            "raw_images": False,
            "record.exclude_regex": "",
            "reset": False,
            "reset.position": 0.05,
            "reset.yaw": 0.3,
            "seed": 0,
        }
        for name, value in defaults.items():
            self.declare_parameter(name, value)
        for name in ("action", "cameras"):
            # One empty text stands for an empty list, which has no type in YAML.
            self.declare_parameter(name, [""])
        self.ended = threading.Event()
        self._lock = threading.RLock()
        self._session: RecordingSession | None = None
        self._number = 0
        self._begun_s = 0.0
        self._success: bool | None = None
        self._saved = self._discarded = 0
        self._failure = ""
        # Device that has driven the robot in this episode.
        self._hand = ""
        # Topics of the cameras by name, once found; whether robot and cameras fit the data set.
        self._cameras: dict[str, str] = {}
        self._is_fitting = False
        self._folder = self._open_folder()
        self._simulation = EpisodeSimulation(self)
        self._lease = LeaseWatch(self)
        self._adding = DataSetGrowth(self, self.publish_state)
        self._status = get_message("diagnostic_msgs/msg/DiagnosticStatus")
        self._key_value = get_message("diagnostic_msgs/msg/KeyValue")
        self._state = self.create_publisher(self._status, "~/state", qos_profile_latched)
        trigger = get_service("std_srvs/srv/Trigger")
        group = MutuallyExclusiveCallbackGroup()
        for name in ("start", "save", "discard", "success"):
            handler = self._answer(getattr(self, name))
            self.create_service(trigger, f"~/{name}", handler, callback_group=group)
        self.create_timer(0.1, self._look, callback_group=group)
        self.publish_state()
        self._adding.begin(self._folder)

    def _open_folder(self) -> EpisodeFolder:
        name = str(self.get_parameter("folder").value)
        if not name:
            raise InvalidParameterError(
                "The recorder of episodes needs a folder",
                hint="Name it: --ros-args -p folder:=my_episodes",
            )
        folder = EpisodeFolder(Path(name))
        fps = self._settings().fps
        if not 1 <= fps <= 1000:
            raise InvalidParameterError(f"Parameter 'fps' is {fps}, not from 1 to 1000")
        if folder.dataset.fps not in (None, fps):
            raise RefusedError(
                f"The data set in {name} has {folder.dataset.fps} frames a second, not {fps}",
                hint=f"Record with --fps {folder.dataset.fps} (parameter 'fps'), or into another "
                "folder.",
            )
        robot, named = folder.dataset.robot, self._settings().robot
        if robot and named and robot != named:
            raise RefusedError(
                f"The data set in {name} is of the robot '{robot}', not '{named}'",
                hint="Record into another folder.",
            )
        folder.begin_recording()
        for left in folder.unfinished():
            self.get_logger().warning(f"An episode that was not saved is in {left}")
        if folder.dataset.episodes:
            count = len(folder.dataset.episodes)
            self.get_logger().info(f"{name} has {count} episodes; new ones are added")
        return folder

    # --- what the services do -------------------------------------------------------------

    def start(self) -> str:
        """Begin an episode, also after one that has failed; return what was done.

        Raises:
            RefusedError: An episode is being recorded.
            UnavailableError: The simulator does not answer.
            SystemFailureError: The bag cannot be created.
        """
        with self._lock:
            if self._session is not None and not self._failure:
                raise RefusedError(f"Episode {self._number} is being recorded: save or discard it")
            if self._session is not None:
                # The written part of the bag is kept.
                with contextlib.suppress(SystemFailureError):
                    self._end()
            number = self._folder.next_number
            self._failure, self._success, self._hand = "", None, ""
            self._adding.problem = ""
            if self.get_parameter("reset").value:
                self._simulation.reset(self._seed, number)
            fitting = EpisodeFitting(
                self,
                self._simulation,
                self._folder.dataset.features,
                prefers_raw=bool(self.get_parameter("raw_images").value),
            )
            settings = self._settings()
            # What has ended since the last episode is waited for again.
            if not self._is_fitting or not fitting.is_published(settings):
                self._is_fitting = False
                fitting.check_state(settings.state)
                self._cameras = fitting.cameras(settings.cameras)
                self._is_fitting = True
            draft = self._folder.draft(number)
            session = RecordingSession(
                self,
                draft,
                RecorderOptions(
                    self._selection(),
                    use_sim_time=bool(self.get_parameter("use_sim_time").value),
                    logs_topics=False,
                ),
                PauseGate(is_open=True),
                lambda *_: None,
                self._fail,
            )
            self._number, self._session, self._begun_s = number, session, time.monotonic()
            if state := self._simulation.state():
                attachment = BagAttachment(
                    STATE_ATTACHMENT, "application/json", state, self.get_clock().nanoseconds()
                )
                session.writing.call(lambda writer: writer.attach(attachment)).result()
            self.get_logger().info(f"Recording episode {number}")
            self.publish_state()
            return f"Recording episode {number}"

    def save(self) -> str:
        """End the running episode and keep it; return what was done.

        Raises:
            RefusedError: No episode is being recorded, or it lacks a feature.
            SystemFailureError: Its bag cannot be written.
        """
        with self._lock:
            session, number = self._running()
            settings = self._settings()
            counts = session.writing.call(lambda writer: dict(writer.message_counts)).result()
            session.writing.call(
                lambda writer: writer.add_record(EPISODE_RECORD, settings.record())
            ).result()
            self._end()
            draft = self._folder.draft_of(number)
            if reason := missing_topics(settings, counts):
                kept = self._folder.reject(draft)
                self.publish_state()
                raise RefusedError(f"Episode {number} {reason}: its bag is in {kept}")
            bag = self._folder.keep(draft, number)
            self._saved += 1
            self.get_logger().info(f"Saved episode {number} into {bag}")
            self._adding.begin(self._folder)
            self.publish_state()
            most = int(self.get_parameter("episodes").value)
            if most and self._saved >= most:
                count = "1 episode is" if self._saved == 1 else f"{self._saved} episodes are"
                self.get_logger().info(f"{count} saved")
                self.ended.set()
            return f"Saved episode {number}"

    def discard(self) -> str:
        """End the running episode and remove its bag; return what was done.

        Raises:
            RefusedError: No episode is being recorded.
        """
        with self._lock:
            if self._session is None:
                self._running()
            number = self._number
            with contextlib.suppress(SystemFailureError):
                self._end()
            self._failure = ""
            self._folder.discard(number)
            self._discarded += 1
            self.get_logger().info(f"Discarded episode {number}")
            self.publish_state()
            return f"Discarded episode {number}"

    def success(self) -> str:
        """Mark the running episode as a success; return what was done.

        Raises:
            RefusedError: No episode is being recorded.
        """
        with self._lock:
            _, number = self._running()
            self._success = True
            self.publish_state()
            return f"Episode {number} is a success"

    def close(self) -> None:
        """End the running episode without saving it, and wait until all are in the data set."""
        with self._lock:
            if self._session is not None:
                number = self._number
                with contextlib.suppress(SystemFailureError):
                    self._end()
                self.get_logger().warning(
                    f"Episode {number} was not saved; its bag is in {self._folder.draft_of(number)}"
                )
        self._adding.wait()
        self._folder.end_recording()

    @property
    def problem(self) -> str:
        """Why the newest episodes are not in the data set; empty if they are."""
        return self._adding.problem

    @property
    def is_recording(self) -> bool:
        """Whether an episode is being recorded."""
        return self._session is not None

    # --- the running episode --------------------------------------------------------------

    def _running(self) -> tuple[RecordingSession, int]:
        if self._failure:
            raise RefusedError(
                f"Episode {self._number} has failed: {self._failure}",
                hint="Start another one, or discard it.",
            )
        if self._session is None:
            raise RefusedError("No episode is being recorded: start one")
        return self._session, self._number

    def _end(self) -> None:
        session, self._session = self._session, None
        assert session is not None
        session.close()
        if losses := session.losses.total():
            lost = sum(losses.in_transport.values()) + sum(losses.in_recorder.values())
            self.get_logger().warning(f"Episode {self._number} has lost {lost} messages")

    def _look(self) -> None:
        """Record which node drives, and save an episode that has reached its maximum duration."""
        if (claim := self._lease.holder) is not None:
            self._hand = claim.device or claim.holder
        limit_s = float(self.get_parameter("episode_time").value)
        with self._lock:
            is_due = limit_s > 0.0 and time.monotonic() - self._begun_s >= limit_s
            if self._session is not None and is_due and not self._failure:
                try:
                    self.save()
                except TeleopctlError as error:
                    self.get_logger().error(_with_hint(error))

    def _fail(self, error: TeleopctlError) -> None:
        """Record that the bag cannot be written; called on the writing thread."""
        self._failure = error.message
        self.get_logger().error(
            f"Episode {self._number} cannot be recorded: {error.message}. The saved ones are kept: "
            "make room or mend this, then start again"
        )
        self.publish_state()

    def _settings(self) -> EpisodeSettings:
        def text(name: str) -> str:
            return str(self.get_parameter(name).value)

        def texts(name: str) -> tuple[str, ...]:
            return tuple(filter(None, map(str, self.get_parameter(name).value)))

        is_placed = bool(self.get_parameter("reset").value)
        return EpisodeSettings(
            text("task"),
            int(self.get_parameter("fps").value),
            text("robot"),
            text("state"),
            texts("action"),
            texts("cameras") or tuple(f"{name}={topic}" for name, topic in self._cameras.items()),
            text("hand"),
            self._success,
            self._hand or text("driven_by"),
            self._seed if is_placed else None,
        )

    @property
    def _seed(self) -> int:
        return int(self.get_parameter("seed").value)

    def _selection(self) -> Selection:
        """Return all topics, but only one of the transports of an image."""
        excluded = _NOT_RECORDED
        if extra := str(self.get_parameter("record.exclude_regex").value):
            excluded = f"{excluded}|{extra}"
        cameras = {text.rpartition("=")[2] for text in self._settings().cameras}
        others = {
            name
            for one in cameras
            for name in (one.removesuffix("/compressed"), f"{one}/compressed")
        }
        return Selection(
            all_topics=True, exclude_topics=sorted(others - cameras), exclude_regex=excluded
        )

    # --- the graph ------------------------------------------------------------------------

    def _answer(self, do: Callable[[], str]) -> Callable[[Any, Any], Any]:
        def answer(request: Any, response: Any) -> Any:
            del request
            try:
                response.success, response.message = True, do()
            except TeleopctlError as error:
                text = _with_hint(error)
                self.get_logger().error(text)
                response.success, response.message = False, text
            return response

        return answer

    def publish_state(self) -> None:
        """Publish the state of the recorder."""
        is_recording = self._session is not None
        state = FAILED if self._failure else RECORDING if is_recording else IDLE
        values = {
            "folder": str(self._folder.folder),
            "task": self._settings().task,
            "episode": str(self._number) if is_recording else "",
            "success": "true" if is_recording and self._success else "",
            "saved": str(self._saved),
            "discarded": str(self._discarded),
            "in_data_set": str(self._adding.count),
            "failure": self._failure or self._adding.problem,
        }
        self._state.publish(
            self._status(
                level=b"\x02" if self._failure else b"\x00",
                name="episode_recorder",
                message=state,
                hardware_id=self._settings().robot,
                values=[self._key_value(key=key, value=value) for key, value in values.items()],
            )
        )


def main(args: Sequence[str] | None = None) -> int:
    """Record episodes until Ctrl-C, SIGTERM or the requested number; return the exit status.

    It is 1 if the newest saved episodes are not in the data set.

    Raises:
        InvalidParameterError: A parameter is missing or has an invalid value.
        RefusedError: The folder has a data set of another kind, or another recorder.
        SystemFailureError: The folder cannot be written.
        MissingExtraError: pyarrow is not installed.
    """
    return record(args=args)


def record(
    *,
    args: Sequence[str] | None = None,
    parameters: Sequence[Parameter] = (),
    shows_keys: bool = False,
) -> int:
    """Record episodes, also for the command line; see `main`.

    Args:
        args: Arguments of the process; None takes ``sys.argv``.
        parameters: Parameters of the node, in addition to those of the arguments.
        shows_keys: Whether to print the keys if the terminal has any.
    """
    progress.report(progress.STARTING)
    status = 0
    with init(args=list(args) if args is not None else None):
        node = EpisodeRecorder(parameters=parameters)
        executor = MultiThreadedExecutor(3)
        executor.add_node(node)
        spin_in_thread(executor)
        progress.report(progress.READY)
        try:
            with Keyboard(lambda key: _press(node, key)):
                if shows_keys and keys_can_be_read():
                    sys.stdout.write(_KEYS)
                while node.context.ok() and not node.ended.wait(0.2):
                    pass
        except KeyboardInterrupt:
            status = 130
        except ExternalShutdownException:
            pass
        finally:
            node.close()
            executor.shutdown()
    return status or int(bool(node.problem))


def _press(node: EpisodeRecorder, key: str) -> None:
    try:
        if key == SPACE:
            (node.save if node.is_recording else node.start)()
        elif key == RIGHT:
            node.success()
            node.save()
        elif key == LEFT:
            node.discard()
        elif key == "q":
            node.ended.set()
    except TeleopctlError as error:
        node.get_logger().error(_with_hint(error))


def _with_hint(error: TeleopctlError) -> str:
    return f"{error.message} ({error.hint})" if error.hint else error.message
