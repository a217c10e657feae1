"""Services of simulation_interfaces that play, pause, step, reset and quit the simulation."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.interfaces import get_action, get_message, get_service
from teleopctl.node import ActionServer
from teleopctl.sim.entities.service_base import Refusal, Result, SimulationServices

if TYPE_CHECKING:
    from teleopctl.sim.entities.running_simulation import RunningSimulation

_State = get_message("simulation_interfaces/msg/SimulationState")
_Features = get_message("simulation_interfaces/msg/SimulatorFeatures")
_Set = get_service("simulation_interfaces/srv/SetSimulationState").Response
_Reset = get_service("simulation_interfaces/srv/ResetSimulation").Request
_SimulateSteps = get_action("simulation_interfaces/action/SimulateSteps")
_GetFeatures = get_service("simulation_interfaces/srv/GetSimulatorFeatures")

_FEATURES = (
    "SPAWNING",
    "DELETING",
    "ENTITY_TAGS",
    "ENTITY_BOUNDS",
    "ENTITY_BOUNDS_BOX",
    "ENTITY_CATEGORIES",
    "SPAWNING_RESOURCE_STRING",
    "ENTITY_STATE_GETTING",
    "ENTITY_STATE_SETTING",
    "ENTITY_INFO_GETTING",
    "ENTITY_INFO_SETTING",
    "SPAWNABLES",
    "NAMED_POSES",
    "POSE_BOUNDS",
    "SIMULATION_RESET",
    "SIMULATION_RESET_TIME",
    "SIMULATION_RESET_STATE",
    "SIMULATION_RESET_SPAWNED",
    "SIMULATION_STATE_GETTING",
    "SIMULATION_STATE_SETTING",
    "SIMULATION_STATE_PAUSE",
    "STEP_SIMULATION_SINGLE",
    "STEP_SIMULATION_MULTIPLE",
    "STEP_SIMULATION_ACTION",
    "WORLD_LOADING",
    "WORLD_RESOURCE_STRING",
    "WORLD_UNLOADING",
    "WORLD_INFO_GETTING",
    "AVAILABLE_WORLDS",
    "SPAWNING_ENTITIES",
)
_FORMATS = ("sdf", "urdf", "mjcf")


class RunServices:
    """Services and an action of simulation_interfaces to play, pause, step, reset and quit.

    Args:
        services: Services of the node, on which these are created.
        quit_simulator: Called to end the simulator once the response is sent.
    """

    def __init__(self, services: SimulationServices, quit_simulator: Callable[[], None]) -> None:
        self._services = services
        self._quit = quit_simulator
        node = services.node
        node.create_service(_GetFeatures, "get_simulator_features", self._report_features)
        services.offer("GetSimulationState", "get_simulation_state", self._get_state)
        services.offer("SetSimulationState", "set_simulation_state", self._set_state)
        services.offer("ResetSimulation", "reset_simulation", self._reset)
        services.offer("StepSimulation", "step_simulation", self._step)
        self._action = ActionServer(node, _SimulateSteps, "simulate_steps", self._simulate)

    # Any, here and below: messages, whose classes are made at run time.
    def _report_features(self, request: Any, response: Any) -> Any:
        del request
        response.features.features = [getattr(_Features, name) for name in _FEATURES]
        response.features.spawn_formats = list(_FORMATS)
        response.features.custom_info = "teleopctl: MuJoCo, one robot, physics in lockstep"
        return response

    def _get_state(self, running: RunningSimulation, request: Any, response: Any) -> None:
        del request
        response.state.state = self._state(running)

    def _state(self, running: RunningSimulation) -> int:
        if not running.loop.paused:
            return int(_State.STATE_PLAYING)
        return int(_State.STATE_STOPPED if running.stopped else _State.STATE_PAUSED)

    def _set_state(self, running: RunningSimulation, request: Any, response: Any) -> None:
        del response
        wanted = request.state.state
        if wanted == _State.STATE_QUITTING:
            self._quit()
        elif wanted == self._state(running) and not running.loop.stepping:
            raise Refusal(_Set.ALREADY_IN_TARGET_STATE, "The simulation is in that state already")
        elif wanted == _State.STATE_STOPPED:
            running.stop()
        elif wanted == _State.STATE_PAUSED:
            running.pause()
        elif wanted == _State.STATE_PLAYING:
            running.play()
        else:
            raise Refusal(_Set.INCORRECT_TRANSITION, "It can be stopped, played, paused and ended")

    def _reset(self, running: RunningSimulation, request: Any, response: Any) -> None:
        del response
        scope = request.scope or _Reset.SCOPE_ALL
        known = _Reset.SCOPE_TIME | _Reset.SCOPE_STATE | _Reset.SCOPE_SPAWNED
        if scope & ~known and scope != _Reset.SCOPE_ALL:
            raise Refusal(Result.RESULT_FEATURE_UNSUPPORTED, f"There is no scope {scope}")
        running.reset(
            time=bool(scope & _Reset.SCOPE_TIME),
            state=bool(scope & _Reset.SCOPE_STATE),
            spawned=bool(scope & _Reset.SCOPE_SPAWNED),
            deleted=scope == _Reset.SCOPE_ALL,
        )

    async def _step(self, running: RunningSimulation, request: Any, response: Any) -> None:
        del response
        await running.step(request.steps)

    async def _simulate(self, goal: Any) -> Any:
        result, steps = _SimulateSteps.Result(), goal.request.steps
        feedback = _SimulateSteps.Feedback(remaining_steps=steps)
        with self._services.answering(result.result):
            while feedback.remaining_steps > 0 and not goal.is_cancel_requested:
                await self._services.running.step(1)
                feedback.completed_steps += 1
                feedback.remaining_steps -= 1
                goal.publish_feedback(feedback)
        if result.result.result != Result.RESULT_OK:
            goal.abort()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.succeed()
        return result
