"""Declarations of verbs and their parameters, independent of the library that parses them.

Importing Typer takes longer than running a graph query, so declarations are made of these small
classes. `quick` uses them for a well-formed command line, `help_page` for ``--help``, `completing`
for Tab completion, and `typer_app` converts them to Typer's to report errors.
"""

from __future__ import annotations

from teleopctl.base.lazy import import_module
from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, dataclass_transform
else:

    def dataclass_transform(**_: object) -> object:
        """Replace `typing.dataclass_transform`, which only type checkers use."""
        return lambda class_: class_


class Declaration:
    """Help text, placeholder, choices and completion of a parameter on the command line.

    Args:
        help: One sentence for ``--help``.
        metavar: Placeholder of the parameter's value in ``--help``.
        choices: Allowed values; empty for any value.
        complete: Completion for Tab: its name in `teleopctl.plugins`, or ``module:function``.
    """

    __slots__ = ("choices", "complete", "help", "metavar")

    def __init__(
        self,
        *,
        help: str,  # noqa: A002 - the word that argument parsers use
        metavar: str | None = None,
        choices: tuple[str, ...] = (),
        complete: str | None = None,
    ) -> None:
        self.help = help
        self.metavar = metavar
        self.choices = choices
        self.complete = complete


class Argument(Declaration):
    """A positional parameter; one of type ``list[str]`` takes all remaining words."""

    __slots__ = ()


class Option(Declaration):
    """A named parameter; one of type ``bool`` is a flag.

    Args:
        flags: Spellings of the option, such as ``"-t", "--show-types"``.
        alone: Value of the option if it is given without one; None if a value is required.
        repeated: For an option of type ``list[str]``: whether the flag is repeated before each
            value. Otherwise all words up to the next option are values.
        rest: For an option of type ``list[str]``: whether all remaining words of the line are
            values, including words that begin with ``-``.
        declaration: Keyword arguments of [`Declaration`][teleopctl.cli.verb.Declaration].
    """

    __slots__ = ("alone", "flags", "repeated", "rest")

    def __init__(
        self,
        *flags: str,
        alone: str | None = None,
        repeated: bool = False,
        rest: bool = False,
        **declaration: Any,  # Any: Declaration has the types
    ) -> None:
        super().__init__(**declaration)
        self.flags = flags
        self.alone = alone
        self.repeated = repeated
        self.rest = rest


class Verb:
    """A verb of the command line: its help, and the function that is imported when it runs.

    Args:
        target: Function of the verb as ``"package.module:function"``, which returns an exit status
            or None.
        help: One line for the list of verbs.
        negative_numbers: Whether ``-1`` is an argument rather than an unknown option.
        passes_on: Whether all words after the first argument are arguments, including options.
        passes_everything_on: Whether all words of the line are arguments, except ``--help`` as the
            first one.
        examples: Command lines that ``--help`` shows at its end.
    """

    __slots__ = (
        "examples",
        "help",
        "negative_numbers",
        "passes_everything_on",
        "passes_on",
        "target",
    )

    def __init__(
        self,
        target: str,
        help: str,  # noqa: A002 - the word that argument parsers use
        *,
        negative_numbers: bool = False,
        passes_on: bool = False,
        passes_everything_on: bool = False,
        examples: tuple[str, ...] = (),
    ) -> None:
        self.target = target
        self.help = help
        self.negative_numbers = negative_numbers
        self.passes_on = passes_on or passes_everything_on
        self.passes_everything_on = passes_everything_on
        self.examples = examples

    def load(self) -> Callable[..., int | None]:
        """Import and return the function of the verb."""
        module, _, name = self.target.partition(":")
        function: Callable[..., int | None] = getattr(import_module(module), name)
        return function


class VerbGroup:
    """A noun with its verbs, such as ``topic``.

    Args:
        help: One line for the list of groups.
        verbs: Verbs by name, in the order of ``--help``.
        alone: Name of the verb that runs if the noun is given alone; "" to show the help.
        leaves_nothing: Whether no verb leaves anything to clean up when its function returns, such
            as an open file or a running thread. The process then ends without finalization.
    """

    __slots__ = ("alone", "help", "leaves_nothing", "verbs")

    def __init__(
        self,
        help: str,  # noqa: A002 - the word that argument parsers use
        verbs: dict[str, Verb],
        *,
        alone: str = "",
        leaves_nothing: bool = False,
    ) -> None:
        self.help = help
        self.verbs = verbs
        self.alone = alone
        self.leaves_nothing = leaves_nothing


@dataclass_transform(kw_only_default=True)
class OptionSet:
    """Base class of options that several verbs share; a verb's function receives one object.

    The annotated attributes are declared like parameters of a function, with their defaults:

        class TextOptions(OptionSet):
            csv: Annotated[bool, Option("--csv", help="Print all values on one line.")] = False

        def echo(topic_name: TopicName, *, text: TextOptions) -> None: ...

    Raises:
        UsageError: Values are invalid or contradict each other; see `check`.
    """

    def __init__(self, **values: object) -> None:
        for name in type(self).__annotations__:
            setattr(self, name, values.get(name, getattr(type(self), name)))
        self.check()

    def check(self) -> None:
        """Do nothing; subclasses raise a UsageError for invalid values when constructed."""


class VerbParameter:
    """A parameter of a verb's function: name, declaration, type and default.

    Attributes:
        name: Name of the function's parameter.
        declaration: `Argument` or `Option` that declares the parameter.
        type: ``str``, ``int``, ``float`` or ``bool``; for a list, the type of its elements.
        many: Whether the parameter is a list.
        optional: Whether the parameter may be left out.
        default: Value of the parameter if it is left out.
    """

    __slots__ = ("declaration", "default", "many", "name", "optional", "type")

    def __init__(
        self,
        name: str,
        declaration: Declaration,
        type_: type,
        *,
        many: bool = False,
        optional: bool = False,
        default: object = None,
    ) -> None:
        self.name = name
        self.declaration = declaration
        self.type = type_
        self.many = many
        self.optional = optional
        self.default = default

    @property
    def takes_value(self) -> bool:
        """Whether the parameter is an option that requires a value."""
        option = self.declaration
        return isinstance(option, Option) and self.type is not bool and option.alone is None


def parameters(function: Callable[..., object]) -> list[VerbParameter]:
    """Return the declared parameters of a verb's function, in order, options of sets included.

    Reads attributes of the function, since ``inspect`` takes as long as a graph query. The
    annotations are evaluated only in a module without ``from __future__ import annotations``.
    """
    code = function.__code__
    positional = code.co_varnames[: code.co_argcount]
    names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    defaults = dict(zip(reversed(positional), reversed(function.__defaults__ or ()), strict=False))
    defaults.update(function.__kwdefaults__ or {})
    found = []
    for name in names:
        annotation = function.__annotations__[name]
        if _is_option_set(annotation):
            found += [
                _parameter(option, declared, {option: getattr(annotation, option)})
                for option, declared in annotation.__annotations__.items()
            ]
        else:
            found.append(_parameter(name, annotation, defaults))
    return found


def call(function: Callable[..., int | None], values: dict[str, object]) -> int | None:
    """Call a verb's function with values by parameter name; return the function's result.

    Args:
        function: Function of the verb.
        values: Values by name of the parameter; those of an option set are passed as one object.

    Raises:
        UsageError: Values of an option set are invalid or contradict each other.
    """
    arguments = dict(values)
    for name, class_ in function.__annotations__.items():
        if _is_option_set(class_):
            own = {option: arguments.pop(option) for option in class_.__annotations__}
            arguments[name] = class_(**own)
    return function(**arguments)


# Any: an annotation may be any object.
def _is_option_set(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, OptionSet)


def _parameter(name: str, annotation: Any, defaults: dict[str, object]) -> VerbParameter:
    scalar, many = _scalar_type(annotation.__origin__)
    return VerbParameter(
        name,
        annotation.__metadata__[0],
        scalar,
        many=many,
        optional=name in defaults,
        default=defaults.get(name),
    )


# Any: an annotation may be any object.
def _scalar_type(annotation: Any) -> tuple[type, bool]:
    """Return ``str`` for ``str``, ``list[str]`` and both with ``| None``; and if it was a list."""
    members: tuple[type, ...] = getattr(annotation, "__args__", ())
    if getattr(annotation, "__origin__", None) is list:
        return members[0], True
    for member in members:
        if member is not type(None):
            return _scalar_type(member)
    return annotation, False
