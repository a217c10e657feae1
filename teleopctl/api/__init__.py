"""Public functions and classes of `teleopctl` that no other package defines.

May import `bag`, `control`, `interfaces`, `mujoco_model`, `node`, `robot`, `sim`, `tf` and `wire`,
and what every package may: `base`, `errors`, `packages` and `plugins`.
"""
