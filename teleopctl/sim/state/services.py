"""mujoco_ros2_control's services: pause, step, reset and save the world, put bodies elsewhere."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.errors import NotFoundError, RefusedError
from teleopctl.packages import resolve_uri
from teleopctl.sim.entities.answers import FindStage, offer_in_words
from teleopctl.sim.overrides import put_bodies, refuse_bodies, refuse_joints, reset_to
from teleopctl.sim.state.saved_state import SavedState

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.sim.entities.stage import RunningSimulation


class MujocoServices:
    """Services of mujoco_ros2_control: pause, step, reset, save and load states.

    Args:
        node: Whose they are.
        find_stage: See `FindStage`.
    """

    def __init__(self, node: Node, find_stage: FindStage) -> None:
        self._node = node
        self._saved: dict[str, SavedState] = {}
        for type_name, name, handler in (
            ("SetPause", "set_pause", self._pause),
            ("StepSimulation", "step_simulation", _step),
            ("ResetWorld", "reset_world", self._reset),
            ("ResetWorld", "save_world", self._save),
            ("SetFreeJointState", "set_free_joint_state", _set_free),
        ):
            offer_in_words(node, find_stage, type_name, f"~/{name}", handler)

    # Any, here and below: messages, whose classes are made at run time.
    def _pause(self, stage: RunningSimulation, request: Any) -> str:
        word = "paused" if request.paused else "running"
        if request.paused:
            stage.pause()
        else:
            stage.play()
        self._node.get_logger().info(f"Simulation is {word}")
        return f"Simulation is {word}"

    def _reset(self, stage: RunningSimulation, request: Any) -> str:
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

        stage.change(change)
        if saved is not None:
            self._node.get_logger().info(f"World set to '{keyframe}'; time begins anew")
            return f"World set to '{keyframe}'; time begins anew"
        where = f"the keyframe '{keyframe}'" if keyframe else "the initial positions"
        self._node.get_logger().info(f"World reset to {where}; time goes on")
        return "World reset"

    def _save(self, stage: RunningSimulation, request: Any) -> str:
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

    def _find(self, stage: RunningSimulation, name: str) -> SavedState:
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


async def _step(stage: RunningSimulation, request: Any) -> str:
    await stage.step(request.steps)
    return f"Advanced by {request.steps} steps"


def _set_free(stage: RunningSimulation, request: Any) -> str:
    simulation, states = stage.simulation, request.free_joints

    def change() -> None:
        _refuse(refuse_bodies(simulation, states))
        put_bodies(simulation, states)

    stage.change(change)
    return f"Set {len(states)} free bodies"
