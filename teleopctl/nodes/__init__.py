"""Programs that ``teleopctl run`` starts, one module with a ``main`` each.

May import `bag`, `base`, `compat`, `control`, `diagram`, `errors`, `interfaces`, `mujoco_model`,
`node`, `packages`, `pictures`, `plugins`, `robot`, `sim`, `tf`, `viewer` and `wire`.
"""
