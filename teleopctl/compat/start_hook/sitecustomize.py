"""Start hook: Python imports this module, because ``PYTHONPATH`` has its folder.

All Python child processes inherit the variable; those without teleopctl are not affected. The
``sitecustomize`` that this one hides, if any, runs first.
"""

import os
import sys
from importlib import import_module


def _run_hidden_sitecustomize() -> None:
    sys.path.remove(os.path.dirname(__file__))  # noqa: PTH120 -- no Path at start-up
    this = sys.modules.pop(__name__)
    try:
        import_module(__name__)
    except ModuleNotFoundError as error:
        if error.name != __name__:
            raise
        sys.modules[__name__] = this


def _activate() -> None:
    # teleopctl's own programs activate the packages themselves, later or not at all.
    if sys.orig_argv[1:3] == ["-P", "-m"] and sys.orig_argv[3].startswith("teleopctl"):
        return
    try:
        from teleopctl.compat.activation import activate
    except ModuleNotFoundError:
        return
    activate()


try:
    _run_hidden_sitecustomize()
finally:
    _activate()
