"""ROS arguments (``--ros-args``) of a command line: remap rules, parameters, log levels.

Source: the ROS 2 design article on command line arguments. Groups start with ``--ros-args`` and
end with ``--`` or the end of the line; arguments outside belong to the program.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from teleopctl.base.printable import shortened
from teleopctl.base.typed import TYPE_CHECKING, Any, NamedTuple
from teleopctl.errors import UsageError
from teleopctl.node.values.names import expand_name, fully_qualified

if TYPE_CHECKING:
    import re
    from pathlib import Path

_RULE = (
    r"^(?:(?P<node>[A-Za-z_][A-Za-z0-9_]*):(?!//|=))?(?P<left>[^:=]+(?:://[^:=]+)?):=(?P<right>.*)$"
)
_FLAGS = {
    "--enable-rosout-logs": ("rosout_logs", True),
    "--disable-rosout-logs": ("rosout_logs", False),
    "--enable-stdout-logs": ("stdout_logs", True),
    "--disable-stdout-logs": ("stdout_logs", False),
    "--enable-external-lib-logs": ("external_lib_logs", True),
    "--disable-external-lib-logs": ("external_lib_logs", False),
}
_ALIASES = {"-r": "--remap", "-p": "--param", "-e": "--enclave"}


class RemapRule(NamedTuple):
    """Remapping ``[NODE:]FROM:=TO``; FROM is a name, ``__ns``, ``__node`` or ``__name``."""

    node: str | None
    match: str
    replacement: str

    def applies_to(self, node_name: str) -> bool:
        """Return whether the rule applies to a node, given its name."""
        return self.node in (None, node_name)


class ParameterRule(NamedTuple):
    """Parameter assignment ``[NODE:]NAME:=VALUE``, with the value parsed as YAML."""

    node: str | None
    name: str
    value: Any  # a YAML value


class RosArguments(NamedTuple):
    """Parsed ROS arguments of a command line, and the arguments of the program."""

    remaps: tuple[RemapRule, ...] = ()
    # Files and single parameters in the order of the command line: later ones override earlier.
    parameters: tuple[ParameterRule | Path, ...] = ()
    log_levels: tuple[tuple[str, str], ...] = ()
    enclave: str = "/"
    rosout_logs: bool = True
    stdout_logs: bool = True
    external_lib_logs: bool = True
    # The command line without ROS arguments.
    program: tuple[str, ...] = ()

    def node_name(self, name: str) -> str | None:
        """Return the remapped name of a node; None if no rule applies."""
        for rule in self.remaps:
            if rule.match in ("__node", "__name") and rule.applies_to(name):
                return rule.replacement
        return None

    def namespace(self, node_name: str) -> str | None:
        """Return the remapped namespace of a node; None if no rule applies."""
        for rule in self.remaps:
            if rule.match == "__ns" and rule.applies_to(node_name):
                return rule.replacement
        return None

    def remap(self, name: str, node_name: str, namespace: str, *, is_service: bool) -> str:
        """Return an absolute topic or service name, remapped by the first rule that applies."""
        for rule in self.remaps:
            match = rule.match
            if match.startswith("__") or not rule.applies_to(node_name):
                continue
            scheme, separator, rest = match.partition("://")
            if separator:
                if (scheme == "rosservice") != is_service:
                    continue
                match = rest
            if expand_name(match, node_name, namespace, is_service=is_service) == name:
                return expand_name(rule.replacement, node_name, namespace, is_service=is_service)
        return name

    # Any: YAML's values, which `Parameter` checks.
    def parameter_overrides(self, node_name: str, namespace: str) -> dict[str, Any]:
        """Return the parameter values for a node; later files and values override earlier ones."""
        full_name = fully_qualified(namespace, node_name)
        overrides: dict[str, Any] = {}
        for source in self.parameters:
            if not isinstance(source, ParameterRule):
                from teleopctl.node.values.parameter_file import read_parameter_file

                overrides.update(read_parameter_file(source).for_node(full_name))
            elif source.node in (None, node_name, full_name):
                overrides[source.name] = source.value
        return overrides


def _groups(args: Sequence[str]) -> tuple[list[str], list[str]]:
    """Separate ROS arguments from those of the program."""
    ros: list[str] = []
    program: list[str] = []
    inside = False
    for word in args:
        if word == "--ros-args":
            inside = True
        elif inside and word == "--":
            inside = False
        else:
            (ros if inside else program).append(word)
    return ros, program


def _value_of(option: str, words: Iterator[str]) -> str:
    try:
        return next(words)
    except StopIteration:
        raise UsageError(
            f"Found '{option}' at the end of --ros-args, but it needs a value"
        ) from None


def _rule(option: str, text: str) -> re.Match[str]:
    import re

    match = re.match(_RULE, text, re.DOTALL)
    if match is None:
        raise UsageError(
            "Failed to parse ROS arguments: "
            f"Couldn't parse the rule '{shortened(text)}' of {option}",
            hint="rules have the form [NODE:]NAME:=VALUE",
        )
    return match


def _parameter_rule(text: str) -> ParameterRule:
    import yaml

    from teleopctl.base import ros_yaml

    match = _rule("--param", text)
    try:
        value = ros_yaml.load_value(match["right"])
    except yaml.YAMLError as error:
        raise UsageError(
            f"The value of parameter '{match['left']}' is not YAML: {shortened(match['right'])!r}: "
            f"{getattr(error, 'problem', None) or error}.",
        ) from error
    from teleopctl.node.values.parameter import parameter_value_problem

    reason = parameter_value_problem(value)
    if reason is not None:
        raise UsageError(
            f"Parameter '{match['left']}' cannot be {shortened(match['right'])!r}: {reason}."
        )
    return ParameterRule(match["node"], match["left"], "" if value is None else value)


def parse_ros_arguments(args: Sequence[str]) -> RosArguments:
    """Parse the ``--ros-args`` groups of a command line; return them and the other arguments.

    Raises:
        UsageError: A rule or an option is malformed; exit status 2.
    """
    ros, program = _groups(args)
    remaps: list[RemapRule] = []
    parameters: list[ParameterRule | Path] = []
    log_levels: list[tuple[str, str]] = []
    settings: dict[str, Any] = {}
    words = iter(ros)
    for word in words:
        option, separator, attached = word.partition("=")
        if not (separator and option.startswith("--")):
            option, attached = word, ""
        option = _ALIASES.get(option, option)
        if option in _FLAGS:
            name, state = _FLAGS[option]
            settings[name] = state
            continue
        if option not in (
            "--remap",
            "--param",
            "--params-file",
            "--log-level",
            "--enclave",
            "--log-config-file",
            "--log-file-name",
        ):
            raise UsageError(
                f"Found unknown ROS arguments: {[word]}",
                hint="end the ROS arguments with -- before the program's own arguments",
            )
        value = attached or _value_of(option, words)
        match option:
            case "--remap":
                rule = _rule(option, value)
                remaps.append(RemapRule(rule["node"], rule["left"], rule["right"]))
            case "--param":
                parameters.append(_parameter_rule(value))
            case "--params-file":
                from pathlib import Path

                parameters.append(Path(value))
            case "--log-level":
                logger, assigned, level = value.partition(":=")
                log_levels.append((logger, level) if assigned else ("", logger))
            case "--enclave":
                settings["enclave"] = value
    return RosArguments(
        remaps=tuple(remaps),
        parameters=tuple(parameters),
        log_levels=tuple(log_levels),
        program=tuple(program),
        **settings,
    )
