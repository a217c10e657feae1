"""Messages, types and filters that are given on the command line, with ROS 2's error texts."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Any, Callable, Iterator, Mapping, contextmanager
from teleopctl.cli.graph_lookup import learn_type
from teleopctl.errors import InvalidMessageError, UsageError

if TYPE_CHECKING:
    from teleopctl.wire import Graph


_PRESENT_TIME = ("auto", "now")


# Any, here and below: classes created from their definitions.
def message_class_named(type_name: str, graph: Graph | None = None) -> type[Any]:
    """Return the message class of a type name given on the command line.

    Args:
        type_name: ``package/msg/Name`` or ``package/Name``.
        graph: ROS graph in which an unknown type is looked up; None to query it.

    Raises:
        InvalidMessageError: The type is unknown or invalid.
    """
    from teleopctl.interfaces import get_message, normalize

    with _passed_type_errors("message"):
        learn_type(normalize(type_name), graph)
        return get_message(type_name)


def service_class_named(type_name: str) -> Any:
    """Return the service class of a type name given on the command line.

    Raises:
        InvalidMessageError: The type is unknown or not a service.
    """
    from teleopctl.interfaces import get_service, normalize

    with _passed_type_errors("service"):
        name = normalize(type_name, "srv")
        if "/srv/" not in name:
            raise InvalidMessageError(f"The passed type is not a service: {name}")
        learn_type(name)
        return get_service(name)


def action_class_named(type_name: str) -> Any:
    """Return the action class of a type name given on the command line.

    Raises:
        InvalidMessageError: The type is unknown or not an action.
    """
    from teleopctl.interfaces import get_action, normalize

    with _passed_type_errors("action"):
        return get_action(normalize(type_name, "action"))


def goal_from_text(action: Any, text: str) -> Any:
    """Return the goal of an action from YAML text given on the command line.

    Raises:
        InvalidMessageError: The values do not match the type, or the text has several documents.
    """
    documents = yaml_documents(text)
    if len(documents) > 1:
        raise InvalidMessageError(f"One goal is sent at a time, got {len(documents)}")
    return message_from_values(
        action.Goal, documents[0], failed="Failed to populate message fields"
    )


def message_from_values(
    message_class: type[Any],
    values: object,
    now: Any = None,  # Any: a time message, as for message_from_yaml
    *,
    failed: str = "Failed to populate field",
) -> Any:
    """Return a message filled with parsed YAML; ``now`` replaces times ``auto`` and ``now``.

    Args:
        message_class: Class of the message.
        values: Content of one YAML document.
        now: Time that replaces ``auto`` and ``now``.
        failed: Beginning of the error message, if the values do not match the type.

    Raises:
        InvalidMessageError: The values do not match the type.
    """
    from teleopctl.interfaces import message_from_yaml

    if not (values is None or isinstance(values, Mapping) or values in _PRESENT_TIME):
        blank = "; a blank must follow each colon" if ":" in str(values) else ""
        raise InvalidMessageError(
            f"The passed value needs to be a dictionary in YAML format, got {values!r}{blank}"
        )
    try:
        # Any: message_from_yaml checks the values itself.
        content: Any = values
        return message_from_yaml(message_class, content, now)
    except UsageError as error:
        text = f"{failed}: {error.message}"
        raise InvalidMessageError(text, hint=error.hint) from error


def yaml_documents(text: str) -> list[object]:
    """Parse YAML text; return its documents as a list, ``[None]`` for an empty text.

    Raises:
        InvalidMessageError: The text is not valid YAML.
    """
    from teleopctl.interfaces import documents_from_yaml

    try:
        return documents_from_yaml(text) or [None]
    except UsageError as error:
        raise InvalidMessageError(
            f"The passed value needs to be in YAML string or a dictionary: {error.message}",
            hint=error.hint,
        ) from error


@contextmanager
def _passed_type_errors(kind: str) -> Iterator[None]:
    try:
        yield
    except (InvalidMessageError, UsageError) as error:
        if error.message.startswith("The passed type"):
            raise
        raise InvalidMessageError(
            f"The passed {kind} type is invalid: {error.message}", hint=error.hint
        ) from error


# Any: message classes are created from their definitions.
def filter_predicate(expression: str) -> Callable[[Any], bool]:
    """Compile a Python expression of ``--filter``; return a function from message to bool.

    Args:
        expression: Python expression, with the message as ``m``: ``m.data > 3``.

    Raises:
        TeleopctlError: The expression is not valid Python. The returned function raises this error
            too, if the expression fails on a message.
    """
    try:
        code = compile(expression, "--filter", "eval")
    except (SyntaxError, ValueError) as error:
        raise UsageError(f"Invalid filter expression '{expression}': {error}") from error

    def wanted(message: Any) -> bool:
        try:
            # The user who runs the command wrote the expression, and has all its permissions.
            return bool(eval(code, {"m": message}))  # noqa: S307
        except Exception as error:
            raise InvalidMessageError(
                f"Filter expression '{expression}' failed: {error}",
                hint="The message is m: --filter 'm.data > 3'"
                if isinstance(error, NameError)
                else None,
            ) from error

    return wanted
