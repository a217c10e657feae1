"""Copy of MuJoCo's data for sensors, with the accelerations that the integrator gives."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco

if TYPE_CHECKING:
    from teleopctl.sim.state.slip_correction import PhysicsStepper

_NO_SENSORS = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
_IMPLICIT = int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)


class StateObserver:
    """Copier of MuJoCo's data for measurements, so that these do not change the simulation.

    MuJoCo's sensors use accelerations from before its integrator treats dampers implicitly: the
    acceleration of a joint by a drive would be measured half as large again.

    Args:
        model: The ``mujoco.MjModel``, whose sensors are disabled outside of `observe`.
        physics: Stepper of the simulation's physics.
    """

    # Any stands for MuJoCo's types, here and below: they have no static ones.
    def __init__(self, model: Any, physics: PhysicsStepper) -> None:
        self._m, self._physics = model, physics
        model.opt.disableflags |= _NO_SENSORS
        self._data: Any = None
        self._next: Any = None

    def observe(self, data: Any, time_s: float, *, moving: bool) -> Any:
        """Return a copy of the data with sensor values, valid until the next call.

        Args:
            data: The ``mujoco.MjData``.
            time_s: Simulated time in seconds; MuJoCo's own restarts at each reset of the state.
            moving: Whether drives may accelerate anything.
        """
        if self._data is None:
            self._data, self._next = mujoco.MjData(self._m), mujoco.MjData(self._m)
        observed = self._data
        mujoco.mj_copyData(observed, self._m, data)
        self._m.opt.disableflags &= ~_NO_SENSORS
        observed.time = time_s
        self._physics.forward(observed)  # with all bodies awake: sleeping ones have no contacts
        # An MJCF file may select another integrator, and has actuators of its own.
        if moving and self._m.opt.integrator == _IMPLICIT:
            mujoco.mj_copyData(self._next, self._m, observed)
            mujoco.mj_implicit(self._m, self._next)
            observed.qacc[:] = (self._next.qvel - observed.qvel) / self._m.opt.timestep
            mujoco.mj_sensorAcc(self._m, observed)
        self._m.opt.disableflags |= _NO_SENSORS
        return observed
