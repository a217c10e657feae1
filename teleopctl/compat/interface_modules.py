"""The modules ``<package>``, ``<package>.msg`` and ``<package>.msg._name`` of interface types."""

from __future__ import annotations

from types import ModuleType

KINDS = ("msg", "srv", "action")


class PackageModule(ModuleType):
    """Module ``<package>`` of a package that has only interfaces."""

    __path__: list[str]

    def __getattr__(self, name: str) -> object:
        # Programs import only std_msgs: in ROS, another message usually has imported std_msgs.msg.
        if name in KINDS and has_package(self.__name__, name):
            from importlib import import_module

            return import_module(f"{self.__name__}.{name}")
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")


class InterfaceModule(ModuleType):
    """Module ``<package>.<kind>``, or ``<package>.<kind>._name``, with interface classes.

    Its attributes are the classes; each is created at the first access.
    """

    __path__: list[str]

    def __getattr__(self, name: str) -> object:
        if name == "__all__":
            return self.__dir__()
        from teleopctl.interfaces import get_class, known_types

        package, kind = self.__name__.split(".")[:2]
        type_name = f"{package}/{kind}/{name}"
        # The list of names leaves out the parts of services and actions, and the types that a
        # user's package adds to a built-in package.
        if name not in self.__dir__() and (
            not _may_be_class(name) or known_types().find(type_name) is None
        ):
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        found = get_class(type_name)
        setattr(self, name, found)
        return found

    def __dir__(self) -> list[str]:
        return class_names(self.__name__)


def class_names(module: str) -> list[str]:
    """Return the names of the classes of an interface module, sorted.

    A module of one definition also has the classes of its parts, where pickle finds them.
    """
    from teleopctl.interfaces import known_types, module_name

    package, kind, *single = module.split(".")
    types = [
        name
        for name in known_types().package_names(package, kind)
        if not single or module_name(name) == module
    ]
    if single:
        types = [part for name in types for part in known_types().parts(name)]
    return [name.rpartition("/")[2] for name in types]


def has_package(package: str, kind: str | None = None) -> bool:
    """Return whether a package defines interfaces, or interfaces of one kind."""
    if not _may_be_package(package):
        return False
    from teleopctl.interfaces import known_types

    return bool(known_types().package_names(package, kind))


def unknown_name(name: str, module: str) -> str:
    """Return the error text for an unknown class of an interface module."""
    from teleopctl.errors import similar_names

    close = similar_names(name, class_names(module))
    also = f"; did you mean {' or '.join(close)}?" if close else ""
    return f"cannot import name {name!r} from {module!r}{also}"


def _may_be_class(name: str) -> bool:
    return name[:1].isupper() and name.isascii() and name.isidentifier()


def _may_be_package(name: str) -> bool:
    return name[:1].islower() and name.islower() and name.isascii() and name.isidentifier()
