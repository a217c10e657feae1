"""Transfer of the state of a model to another one, by the names of common parts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

_Object = mujoco.mjtObj
_Numbers = npt.NDArray[np.intp]

# Number of positions and of velocities of a joint by its type: free, ball, slide, hinge.
_POSITIONS = np.array([7, 4, 1, 1])
_DOFS = np.array([6, 3, 1, 1])


# Any, here and below: MuJoCo's models and data have no types.
def copy_state(m: Any, d: Any, new_m: Any, new_d: Any) -> None:
    """Copy the simulation state to a new model's data, by names of joints and bodies.

    Joints, actuators and bodies of the same name keep their state and applied forces. Unnamed
    elements, which only robots have, are matched in their order.

    Args:
        m: The present ``mujoco.MjModel``.
        d: Data of ``m``.
        new_m: Model that replaces ``m``; its gravity and the poses of its bodies are set as in
            ``m``.
        new_d: Data of ``new_m``, just created.
    """
    new_m.opt.gravity[:] = m.opt.gravity
    new_d.time = d.time
    # With arrays: there may be thousands of joints, and simulation time stands still.
    old, new = _common(m, new_m, _Object.mjOBJ_JOINT)
    kinds = m.jnt_type[old]
    here = _spans(m.jnt_qposadr[old], _POSITIONS[kinds])
    there = _spans(new_m.jnt_qposadr[new], _POSITIONS[kinds])
    new_d.qpos[there] = d.qpos[here]
    here = _spans(m.jnt_dofadr[old], _DOFS[kinds])
    there = _spans(new_m.jnt_dofadr[new], _DOFS[kinds])
    for field in ("qvel", "qacc", "qacc_warmstart", "qfrc_applied"):
        getattr(new_d, field)[there] = getattr(d, field)[here]
    old, new = _common(m, new_m, _Object.mjOBJ_ACTUATOR)
    new_d.ctrl[new] = d.ctrl[old]
    counts = m.actuator_actnum[old]
    here, there = _spans(m.actuator_actadr[old], counts), _spans(new_m.actuator_actadr[new], counts)
    new_d.act[there] = d.act[here]
    old, new = _common(m, new_m, _Object.mjOBJ_BODY)
    new_d.xfrc_applied[new] = d.xfrc_applied[old]
    new_m.body_pos[new], new_m.body_quat[new] = m.body_pos[old], m.body_quat[old]
    held = m.body_mocapid[old] >= 0
    here, there = m.body_mocapid[old][held], new_m.body_mocapid[new][held]
    new_d.mocap_pos[there], new_d.mocap_quat[there] = d.mocap_pos[here], d.mocap_quat[here]
    old, new = _common(m, new_m, _Object.mjOBJ_EQUALITY)
    new_d.eq_active[new] = d.eq_active[old]


def _common(m: Any, new_m: Any, kind: mujoco.mjtObj) -> tuple[_Numbers, _Numbers]:
    """Return the indices of the elements that both models have, in each of the two models."""
    there = {key: number for number, key in enumerate(_keys(new_m, kind))}
    pairs = [(old, there[key]) for old, key in enumerate(_keys(m, kind)) if key in there]
    old, new = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
    return old, new


def _keys(m: Any, kind: mujoco.mjtObj) -> Iterator[str | int]:
    count = {
        _Object.mjOBJ_JOINT: m.njnt,
        _Object.mjOBJ_ACTUATOR: m.nu,
        _Object.mjOBJ_BODY: m.nbody,
        _Object.mjOBJ_EQUALITY: m.neq,
    }[kind]
    unnamed = 0
    for number in range(count):
        name = mujoco.mj_id2name(m, kind, number)
        if not name:
            unnamed += 1
        yield name or unnamed


def _spans(starts: _Numbers, counts: _Numbers) -> _Numbers:
    """Return the indices of several spans, concatenated."""
    ends = np.cumsum(counts)
    total = int(ends[-1]) if len(ends) else 0
    return np.repeat(starts - ends + counts, counts) + np.arange(total)
