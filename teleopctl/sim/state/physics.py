"""Functions on MuJoCo's whole model and data: scale, save, restore, wake."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

# All that a step starts from, to the last bit: also controls and the solver's warm start.
_ALL = mujoco.mjtState.mjSTATE_INTEGRATION
_SLEEP_ARRAYS = (
    *("tree_asleep", "tree_awake", "body_awake"),
    *("body_awake_ind", "parent_awake_ind", "dof_awake_ind"),
)
_SLEEP_COUNTS = ("ntree_awake", "nbody_awake", "nparent_awake", "nv_awake")
_Object = mujoco.mjtObj
_NAMED = {
    "body": (_Object.mjOBJ_BODY, "nbody"),
    "joint": (_Object.mjOBJ_JOINT, "njnt"),
    "actuator": (_Object.mjOBJ_ACTUATOR, "nu"),
    "equality": (_Object.mjOBJ_EQUALITY, "neq"),
}


# Any stands for MuJoCo's types, here and below: they have no static ones.
def scale_model(model: Any, mass: float, friction: float) -> None:
    """Multiply a MuJoCo model's masses, inertias and frictions by factors; gains of drives stay."""
    if mass != 1.0:
        model.body_mass[:] *= mass
        model.body_inertia[:] *= mass
        # Recompute the constants that MuJoCo derives from masses.
        mujoco.mj_setConst(model, mujoco.MjData(model))
    if friction != 1.0:
        model.geom_friction[:] *= friction
        model.pair_friction[:] *= friction


def physics_state(model: Any, data: Any) -> dict[str, Array]:
    """Return MuJoCo's state, the gravity and the poses of static objects, as arrays."""
    state = np.zeros(mujoco.mj_stateSize(model, _ALL))
    mujoco.mj_getState(model, data, state, _ALL)
    return {
        "physics": state,
        "gravity": np.array(model.opt.gravity),
        "asleep": _sleep(data),
        "standing": np.concatenate([model.body_pos.ravel(), model.body_quat.ravel()]),
    }


def put_physics_state(model: Any, data: Any, saved: Mapping[str, Array]) -> None:
    """Set MuJoCo's state, the gravity and static poses to what `physics_state` returned."""
    mujoco.mj_setState(model, data, saved["physics"], _ALL)
    model.opt.gravity[:] = saved["gravity"]
    _put_sleep(data, saved["asleep"])
    places = 3 * model.nbody
    model.body_pos[:] = saved["standing"][:places].reshape(-1, 3)
    model.body_quat[:] = saved["standing"][places:].reshape(-1, 4)


def _sleep(data: Any) -> Array:
    """Return which bodies sleep, and when the others will: no part of MuJoCo's own state."""
    arrays = [np.asarray(getattr(data, name), float).ravel() for name in _SLEEP_ARRAYS]
    counts = [float(getattr(data, name)) for name in _SLEEP_COUNTS]
    return np.concatenate([*arrays, counts])


def _put_sleep(data: Any, saved: Array) -> None:
    at = 0
    for name in _SLEEP_ARRAYS:
        array = getattr(data, name)
        array[:] = saved[at : at + array.size].reshape(array.shape).astype(array.dtype)
        at += array.size
    for name, count in zip(_SLEEP_COUNTS, saved[at:], strict=True):
        setattr(data, name, int(count))


def part_names(model: Any) -> list[str]:
    """Return texts like ``body 'NAME'`` for a model's bodies, joints, actuators and equalities."""
    return [
        f"{word} '{mujoco.mj_id2name(model, kind, number) or number}'"
        for word, (kind, count) in _NAMED.items()
        for number in range(getattr(model, count))
    ]


def wake(model: Any, data: Any) -> None:
    """Recompute all bodies, sleeping ones included, after something around them has changed.

    While bodies may sleep, MuJoCo computes the poses of static bodies only once.
    """
    with nothing_asleep(model):
        mujoco.mj_forward(model, data)


@contextmanager
def nothing_asleep(model: Any) -> Iterator[None]:
    """Disable MuJoCo's sleeping of bodies within the ``with`` block."""
    asleep = model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_SLEEP
    model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    try:
        yield
    finally:
        model.opt.enableflags |= asleep
