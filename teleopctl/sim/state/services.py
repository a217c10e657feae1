"""mujoco_ros2_control's services: pause, step, reset and save the world, put bodies elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.errors import NotFoundError, RefusedError, TeleopctlError
from teleopctl.interfaces import get_service
from teleopctl.packages import resolve_uri
from teleopctl.sim.overrides import put_bodies, refuse_bodies, refuse_joints, reset_to
from teleopctl.sim.state.saved_state import SavedState

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.sim.entities.stage import Stage

_SetPause = get_service("mujoco_ros2_control_msgs/srv/SetPause")
_StepSimulation = get_service("mujoco_ros2_control_msgs/srv/StepSimulation")
_ResetWorld = get_service("mujoco_ros2_control_msgs/srv/ResetWorld")
_SetFreeJointState = get_service("mujoco_ros2_control_msgs/srv/SetFreeJointState")

# Any, here and below: messages, whose classes are made at run time.
Handler = Callable[["Stage", Any], str]


class MujocoServices:
    """Offers the services, and keeps the states that were saved under a name.

    Args:
        node: Whose they are.
        stage: Returns what they work with, or None while there is no robot.
    """

    def __init__(self, node: Node, stage: Callable[[], Stage | None]) -> None:
        self._node, self._stage = node, stage
        self._saved: dict[str, SavedState] = {}
        self._offer(_SetPause, "~/set_pause", self._pause)
        self._offer(_StepSimulation, "~/step_simulation", _step)
        self._offer(_ResetWorld, "~/reset_world", self._reset)
        self._offer(_ResetWorld, "~/save_world", self._save)
        self._offer(_SetFreeJointState, "~/set_free_joint_state", _set_free)

    def _offer(self, service: Any, name: str, handler: Handler) -> None:
        def answer(request: Any, response: Any) -> Any:
            try:
                stage = self._stage()
                if stage is None:
                    raise RefusedError("There is no robot yet")
                response.message, response.success = handler(stage, request), True
            except TeleopctlError as error:
                response.message, response.success = error.message, False
            return response

        self._node.create_service(service, name, answer)

    def _pause(self, stage: Stage, request: Any) -> str:
        word = "paused" if request.paused else "running"
        if request.paused:
            stage.pause()
        else:
            stage.play()
        self._node.get_logger().info(f"Simulation is {word}")
        return f"Simulation is {word}"

    def _reset(self, stage: Stage, request: Any) -> str:
        keyframe, overrides = request.keyframe, request.state_overrides
        simulation, saved = stage.simulation, None
        if keyframe and keyframe not in simulation.model.keyframes:
            saved = self._find(stage, keyframe)
            if overrides.joint_states.name:
                raise RefusedError(
                    "The joints of a saved state are where its drives hold them: only free_joints "
                    "of state_overrides go with it"
                )

        def change() -> None:
            _refuse(refuse_joints(simulation, overrides.joint_states))
            _refuse(refuse_bodies(simulation, overrides.free_joints))
            if saved is None:
                reset_to(simulation, overrides, keyframe)
                return
            saved.put(simulation)
            put_bodies(simulation, overrides.free_joints)
            stage.begin_anew()

        stage.ask(change)
        if saved is not None:
            self._node.get_logger().info(f"World set to '{keyframe}'; time begins anew")
            return f"World set to '{keyframe}'; time begins anew"
        where = f"the keyframe '{keyframe}'" if keyframe else "the initial positions"
        self._node.get_logger().info(f"World reset to {where}; time goes on")
        return "World reset"

    def _save(self, stage: Stage, request: Any) -> str:
        name, overrides = request.keyframe, request.state_overrides
        if not name:
            raise RefusedError("A state needs a name, or the path of a file, as its keyframe")
        if overrides.joint_states.name or overrides.free_joints:
            raise RefusedError("A state is saved as it is: state_overrides are for reset_world")
        if name in stage.simulation.model.keyframes:
            raise RefusedError(f"The model has a keyframe '{name}': choose another name")
        state = stage.ask(lambda: SavedState.of(stage.simulation))
        if file := _file(name):
            state.write(file)
            return f"Saved into {file}"
        self._saved[name] = state
        return f"Saved as '{name}'"

    def _find(self, stage: Stage, name: str) -> SavedState:
        if file := _file(name):
            return SavedState.read(file)
        if name in self._saved:
            return self._saved[name]
        known = [*stage.simulation.model.keyframes, *self._saved]
        there_is = f"; there is {', '.join(known)}" if known else ""
        raise NotFoundError(f"There is no keyframe '{name}'{there_is}")


def _file(name: str) -> Path | None:
    """The file that a keyframe names; None where it is a name."""
    if "/" not in name:
        return None
    path = resolve_uri(name)
    if not path.is_absolute():
        raise RefusedError(f"'{name}' starts nowhere: give a file by its whole path")
    return path


def _refuse(reason: str) -> None:
    if reason:
        raise RefusedError(reason)


def _step(stage: Stage, request: Any) -> str:
    if not stage.loop.paused:
        raise RefusedError("The simulation can be stepped only while paused")
    if request.steps == 0:
        raise RefusedError("The number of steps is 0")
    if not stage.loop.step(request.steps, max(30.0, 0.01 * request.steps)):
        raise RefusedError("The steps took too long")
    return f"Advanced by {request.steps} steps"


def _set_free(stage: Stage, request: Any) -> str:
    simulation, states = stage.simulation, request.free_joints

    def change() -> None:
        _refuse(refuse_bodies(simulation, states))
        put_bodies(simulation, states)

    stage.ask(change)
    return f"Set {len(states)} free bodies"
