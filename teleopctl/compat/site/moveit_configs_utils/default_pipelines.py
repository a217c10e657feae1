"""MoveIt's default planning pipelines, for configuration packages without files of them.

The planners of OMPL are listed with their types only: what they are not given they take from OMPL.
"""

from __future__ import annotations

from typing import Any

_REQUEST_ADAPTERS = (
    "ResolveConstraintFrames",
    "ValidateWorkspaceBounds",
    "CheckStartStateBounds",
    "CheckStartStateCollision",
)
_OMPL_PLANNERS = """
AnytimePathShortening SBL EST LBKPIECE BKPIECE KPIECE RRT RRTConnect RRTstar TRRT PRM PRMstar FMT
BFMT PDST STRIDE BiTRRT LBTRRT BiEST ProjEST LazyPRM LazyPRMstar SPARS SPARStwo
"""

NAMES = ("chomp", "ompl", "pilz_industrial_motion_planner", "stomp")
"""Their names."""


# Any: values of any kind.
def default_pipeline(name: str) -> dict[str, Any]:
    """Return the parameters of a default pipeline."""
    own: dict[str, dict[str, Any]] = {
        "chomp": {
            "planning_plugins": ["chomp_interface/CHOMPPlanner"],
            "enable_failure_recovery": True,
            "ridge_factor": 0.01,
        },
        "ompl": {"planning_plugins": ["ompl_interface/OMPLPlanner"]},
        "pilz_industrial_motion_planner": {
            "planning_plugins": ["pilz_industrial_motion_planner/CommandPlanner"],
            "default_planner_config": "PTP",
            "capabilities": "pilz_industrial_motion_planner/MoveGroupSequenceAction "
            "pilz_industrial_motion_planner/MoveGroupSequenceService",
        },
        "stomp": {
            "planning_plugins": ["stomp_moveit/StompPlanner"],
            "stomp_moveit": {
                "num_timesteps": 60,
                "num_iterations": 40,
                "num_iterations_after_valid": 0,
                "num_rollouts": 30,
                "max_rollouts": 30,
                "exponentiated_cost_sensitivity": 0.8,
                "control_cost_weight": 0.1,
                "delta_t": 0.1,
            },
        },
    }
    # The Pilz planner gives times to its trajectories itself.
    timing = () if name.startswith("pilz") else ("AddTimeOptimalParameterization",)
    return own[name] | {
        "request_adapters": [
            f"default_planning_request_adapters/{adapter}" for adapter in _REQUEST_ADAPTERS
        ],
        "response_adapters": [
            f"default_planning_response_adapters/{adapter}"
            for adapter in (*timing, "ValidateSolution", "DisplayMotionPath")
        ],
    }


def ompl_planners() -> dict[str, dict[str, str]]:
    """Return the OMPL planners, as the pipeline has them under ``planner_configs``."""
    return {name: {"type": f"geometric::{name}"} for name in _OMPL_PLANNERS.split()}
