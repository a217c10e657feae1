"""The state of one model carried over into another one, by the names of what is in both."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import mujoco

_Object = mujoco.mjtObj
# How many numbers positions and velocities of a joint are, where not one each.
_SIZES = {
    int(mujoco.mjtJoint.mjJNT_FREE): (7, 6),
    int(mujoco.mjtJoint.mjJNT_BALL): (4, 3),
}


# Any, here and below: MuJoCo's models and data have no types.
def carry_over(m: Any, d: Any, new_m: Any, new_d: Any) -> None:
    """Bring a new model and its data to the state of others.

    Joints, actuators and bodies of the same name go on as they were, pushed as they were. So do
    those without a name, one after the other, of which only robots have some.

    Args:
        m: The ``mujoco.MjModel`` so far.
        d: Its ``mujoco.MjData``.
        new_m: The model that takes its place, whose places of things that stand still change.
        new_d: Its data, new.
    """
    new_m.opt.gravity[:] = m.opt.gravity
    new_d.time = d.time
    for old, new in _common(m, new_m, _Object.mjOBJ_JOINT):
        (positions, dofs), (new_positions, new_dofs) = _places(m, old), _places(new_m, new)
        new_d.qpos[new_positions] = d.qpos[positions]
        for field in ("qvel", "qacc", "qacc_warmstart", "qfrc_applied"):
            getattr(new_d, field)[new_dofs] = getattr(d, field)[dofs]
    for old, new in _common(m, new_m, _Object.mjOBJ_ACTUATOR):
        new_d.ctrl[new] = d.ctrl[old]
        count = int(m.actuator_actnum[old])
        here, there = int(m.actuator_actadr[old]), int(new_m.actuator_actadr[new])
        new_d.act[there : there + count] = d.act[here : here + count]
    for old, new in _common(m, new_m, _Object.mjOBJ_BODY):
        new_d.xfrc_applied[new] = d.xfrc_applied[old]
        new_m.body_pos[new], new_m.body_quat[new] = m.body_pos[old], m.body_quat[old]
        if m.body_mocapid[old] >= 0:
            here, there = int(m.body_mocapid[old]), int(new_m.body_mocapid[new])
            new_d.mocap_pos[there], new_d.mocap_quat[there] = d.mocap_pos[here], d.mocap_quat[here]
    for old, new in _common(m, new_m, _Object.mjOBJ_EQUALITY):
        new_d.eq_active[new] = d.eq_active[old]


def _common(m: Any, new_m: Any, kind: mujoco.mjtObj) -> Iterator[tuple[int, int]]:
    """Numbers of what is in both models: in the first, and in the second."""
    there = {key: number for number, key in enumerate(_keys(new_m, kind))}
    for number, key in enumerate(_keys(m, kind)):
        if key in there:
            yield number, there[key]


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


def _places(m: Any, joint: int) -> tuple[slice, slice]:
    """Where a joint has its positions and its velocities."""
    positions, velocities = _SIZES.get(int(m.jnt_type[joint]), (1, 1))
    first, dof = int(m.jnt_qposadr[joint]), int(m.jnt_dofadr[joint])
    return slice(first, first + positions), slice(dof, dof + velocities)
