"""``launch.frontend``."""

import importlib
from typing import TYPE_CHECKING, Any

from .expose import expose_action, expose_substitution

if TYPE_CHECKING:
    from . import type_utils
    from .entity import Entity
    from .parser import Parser

__all__ = ["Entity", "Parser", "expose_action", "expose_substitution", "type_utils"]


# Any: attributes of a module. What is here needs actions and substitutions, which need `expose`.
def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = importlib.import_module(f".{name.lower()}", __name__)
    return module if name == "type_utils" else getattr(module, name)
