"""Launch files: ROS 2's launch, and the supervisor of what it starts.

A front end reads a file (`frontends`) into steps with actions (`actions`, over `model`), which are
evaluated with the launch arguments into a plan of processes (`evaluation`). The plan is carried out
(`execution`), in the foreground or, through ``python -m teleopctl.launch``, in the background.

An action of one's own derives from ``Action``, a substitution is a ``Substitution``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.launch.actions.messages import Log as Log
    from teleopctl.launch.actions.process import Executable as Executable
    from teleopctl.launch.actions.process import Node as Node
    from teleopctl.launch.evaluation.context import LaunchContext as LaunchContext
    from teleopctl.launch.evaluation.substitution import Substitution as Substitution
    from teleopctl.launch.model.action import Action as Action
    from teleopctl.launch.model.action import Entity as Entity
    from teleopctl.launch.model.action import Launch as Launch
    from teleopctl.launch.model.action import Step as Step
    from teleopctl.launch.model.descriptions import NodePart as NodePart
    from teleopctl.launch.model.template import Template as Template
    from teleopctl.launch.model.template import literal as literal
else:
    from teleopctl.lazy import attach

    __getattr__, __all__ = attach(
        __name__,
        {
            "actions.messages": "Log",
            "actions.process": "Executable Node",
            "evaluation.context": "LaunchContext",
            "evaluation.substitution": "Substitution",
            "model.action": "Action Entity Launch Step",
            "model.descriptions": "NodePart",
            "model.template": "Template literal",
        },
    )
