"""Registry of all plug-ins by kind and name: controllers, sensors, verbs and so on.

A kind of plug-in has an entry-point group and a table of teleopctl's own plug-ins. An installed
distribution adds a plug-in with an entry in its ``pyproject.toml``:

    [project.entry-points."teleopctl.controllers"]
    "my_controllers/Gripper" = "my_controllers.gripper:Gripper"

Entry points are read from the metadata of every installed distribution, which takes tens of
milliseconds. So teleopctl's own plug-ins are in tables in the modules of this package, and the
entry points are read only to find a name that is in no table, or to list all names. teleopctl's own
plug-ins have precedence over others of the same name.

A plug-in is imported when it is first used, so that a broken plug-in has no other effects.

May import `base` and `errors` only.
"""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.plugins.command_line import COMPLETIONS as COMPLETIONS, VERBS as VERBS
    from teleopctl.plugins.lookup import (
        Kind as Kind,
        Plugin as Plugin,
        available as available,
        find as find,
        import_object as import_object,
        load as load,
    )
    from teleopctl.plugins.reloading import (
        Reloaded as Reloaded,
        reload as reload,
        remember_sources as remember_sources,
        source_files as source_files,
    )
    from teleopctl.plugins.tables import (
        COMPONENTS as COMPONENTS,
        CONTROLLERS as CONTROLLERS,
        DISPLAYS as DISPLAYS,
        FILTERS as FILTERS,
        HARDWARE as HARDWARE,
        LAUNCH_ACTIONS as LAUNCH_ACTIONS,
        LAUNCH_EXTENSIONS as LAUNCH_EXTENSIONS,
        LAUNCH_LANGUAGES as LAUNCH_LANGUAGES,
        LAUNCH_SUBSTITUTIONS as LAUNCH_SUBSTITUTIONS,
        NODES as NODES,
        PACKAGES as PACKAGES,
        PANELS as PANELS,
        SENSORS as SENSORS,
        TELEOP_DEVICES as TELEOP_DEVICES,
        WRITE_DEFINITIONS as WRITE_DEFINITIONS,
        kinds as kinds,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
