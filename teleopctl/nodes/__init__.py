"""Programs that ``teleopctl run`` starts, one module with a ``main`` each.

May import `bag`, `compat`, `control`, `diagram`, `interfaces`, `mujoco_model`, `node`, `robot`,
`sim`, `tf`, `viewer` and `wire`, besides `base`, `errors`, `packages` and `plugins`.
"""
