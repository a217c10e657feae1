"""Functions that write and read messages as CDR, generated when they are first used.

Most types are only sent or only received, and few are received in both byte orders.
"""

from __future__ import annotations

from _thread import RLock

from teleopctl.base.typed import TYPE_CHECKING, Any, Callable, NamedTuple, TypeAlias
from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces.cdr.codegen import Generator
from teleopctl.interfaces.cdr.layout import Layout
from teleopctl.interfaces.cdr.reading import ReaderGenerator
from teleopctl.interfaces.cdr.writing import WriterGenerator

if TYPE_CHECKING:
    from types import CodeType

Writer: TypeAlias = Callable[[bytearray, Any], None]
"""Function that appends a message to data, which so far has only the encapsulation header."""

Reader: TypeAlias = Callable[[Any, memoryview, int, int], tuple[Any, int]]
"""Function of the data, a memoryview of the data, the position of the message and the size of the
data; returns the message and the position after the message."""


class _Key(NamedTuple):
    type_name: str
    direction: str
    is_nested: bool


class Codecs:
    """Cache of generated functions that read and write messages as CDR; thread-safe.

    Tracebacks and debuggers find the source of a function, which is its attribute ``__source__``.

    Args:
        message_class: Function that returns the class of a message type by its full name.

    Attributes:
        message_class: Function that returns the class of a message type by its full name.
    """

    # Any, here and in the code generator: values of generated code.
    def __init__(self, message_class: Callable[[str], type[Any]]) -> None:
        self.message_class = message_class
        self._layout = Layout(lambda name: message_class(name).__definition__)
        self._functions: dict[_Key, Any] = {}
        self._lock = RLock()

    def writer(self, type_name: str) -> Writer:
        """Return the function that appends a message of a type to a bytearray as CDR.

        Raises:
            InvalidMessageError: The type cannot be sent.
        """
        function: Writer = self._find(_Key(type_name, "write", False))
        return function

    def reader(self, type_name: str, is_little: bool) -> Reader:
        """Return the function that parses a message of a type from CDR in one byte order.

        Raises:
            InvalidMessageError: The type cannot be received.
        """
        direction = "read_little" if is_little else "read_big"
        function: Reader = self._find(_Key(type_name, direction, False))
        return function

    def _find(self, key: _Key) -> Any:
        found = self._functions.get(key)
        if found is None:
            with self._lock:
                found = self._functions.get(key)
                if found is None:
                    found = self._functions[key] = self._make(key)
        return found

    def _make(self, key: _Key) -> Any:
        def nested(type_name: str) -> Any:
            return self._find(key._replace(type_name=type_name, is_nested=True))

        try:
            self._layout.check(key.type_name)
            generator: Generator = (
                WriterGenerator(self._layout, nested)
                if key.direction == "write"
                else ReaderGenerator(
                    self._layout, nested, self.message_class, key.direction == "read_little"
                )
            )
            source = generator.function_source(key.type_name, key.is_nested)
            return _compile(key, source, generator.constants)
        except RecursionError:
            raise InvalidMessageError(f"{key.type_name} is nested too deeply") from None


class _Source:
    """Module loader from which tracebacks get the source of a generated function."""

    def __init__(self, source: str) -> None:
        self._source = source

    def get_source(self, _name: str) -> str:
        return self._source


def _in_file(code: CodeType, file: str) -> CodeType:
    """Return code with a file name for tracebacks, also in the code of inner functions."""
    constants = (
        _in_file(each, file) if isinstance(each, type(code)) else each for each in code.co_consts
    )
    return code.replace(co_filename=file, co_consts=tuple(constants))


def _compile(key: _Key, source: str, constants: dict[str, Any]) -> Any:
    suffix = "_nested" if key.is_nested else ""
    name = f"cdr/{key.type_name}/{key.direction}{suffix}"
    namespace = {**constants, "__name__": name, "__loader__": _Source(source)}
    # exec() gets text: compile() would first create the classes of the module ast, which takes
    # longer than everything else here.
    try:
        exec(source, namespace)  # noqa: S102 - source from names and numbers of definitions
    except KeyboardInterrupt:
        from teleopctl.base import interrupts

        interrupts.clear_exec_interrupt()
        raise
    function: Any = namespace[key.direction.partition("_")[0]]
    function.__code__ = _in_file(function.__code__, f"{name}.py")
    function.__source__ = source
    return function
