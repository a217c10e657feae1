"""``teleopctl logger``: levels of the loggers of running nodes, and their log."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import absolute_name
from teleopctl.cli.options import AsJson, NodeName
from teleopctl.cli.verb import Argument, Option, Verb, VerbGroup
from teleopctl.errors import NotFoundError, RefusedError, TeleopctlError, did_you_mean

if TYPE_CHECKING:
    from collections.abc import Mapping

    from teleopctl.wire import Graph

GROUP = VerbGroup(
    "Read, change and watch the logging of running nodes.",
    {
        "list": Verb(f"{__name__}:list_levels", "List the nodes with the levels of their loggers."),
        "get": Verb(f"{__name__}:get_level", "Print the level of a node's logger."),
        "set": Verb(
            f"{__name__}:set_level",
            "Set the level of a node's logger.",
            examples=("teleopctl logger set /talker debug",),
        ),
        "watch": Verb(
            f"{__name__}:watch",
            "Print the log of nodes until Ctrl-C.",
            examples=("teleopctl logger watch --level warn", "teleopctl logger watch /talker"),
        ),
    },
)

LEVELS = {"unset": 0, "debug": 10, "info": 20, "warn": 30, "error": 40, "fatal": 50}
"""Levels by the names on the command line."""

_NAMES = {number: name.upper() for name, number in LEVELS.items()}
_GET, _SET = "get_logger_levels", "set_logger_levels"
_TIMEOUT_S = 2.0
_HOW = (
    "They are off by default, as in ROS 2. Start the node by `teleopctl run --logger-services` or "
    "`teleopctl launch --logger-services`, or with TELEOPCTL_LOGGER_SERVICES=1 in the environment; "
    "a program turns them on by enable_logger_service=True."
)

LoggerName = Annotated[
    str | None,
    Argument(help="Name of a logger of its process; by default the node's own.", metavar="LOGGER"),
]


def list_levels(as_json: AsJson = False) -> None:
    """List the nodes with the levels of their loggers.

    Levels are read by services that ROS 2 leaves off by default. Nodes without them are named.
    """
    with _Loggers() as loggers:
        nodes = loggers.graph.node_names()
        offering = [node for node in nodes if loggers.offers(node)]
        levels = loggers.levels({node: _logger_of(node) for node in offering})
    silent = [node for node in nodes if node not in offering]
    if as_json:
        console.out_json({**dict.fromkeys(silent), **levels})
        return
    console.out_lines(f"{node}: {_shown(level)}" for node, level in levels.items())
    console.flush()
    if silent:
        console.note(f"Without services for it: {', '.join(silent)}")
        console.note(f"  {_HOW}")


def get_level(node_name: NodeName, logger_name: LoggerName = None, as_json: AsJson = False) -> None:
    """Print the level of a node's logger."""
    with _Loggers() as loggers:
        node = loggers.find(node_name)
        (level,) = loggers.levels({node: logger_name or _logger_of(node)}, strict=True).values()
    if as_json:
        console.out_json({"node": node, "logger": logger_name or _logger_of(node), "level": level})
    else:
        console.out(_shown(level))


def set_level(
    node_name: NodeName,
    level: Annotated[str, Argument(help="The level.", choices=(*LEVELS, *map(str.upper, LEVELS)))],
    logger_name: LoggerName = None,
    as_json: AsJson = False,
) -> None:
    """Set the level of a node's logger; ``unset`` makes it that of its parent."""
    number = LEVELS[level.lower()]
    with _Loggers() as loggers:
        node = loggers.find(node_name)
        logger = logger_name or _logger_of(node)
        loggers.set(node, logger, number)
    console.out_done(
        f"The level of {logger} is {_NAMES[number]}",
        as_json=as_json,
        node=node,
        logger=logger,
        level=_NAMES[number],
    )


def watch(
    node_names: Annotated[
        list[str] | None,
        Argument(metavar="NODE", help="Nodes; by default all.", complete="nodes"),
    ] = None,
    level: Annotated[
        str,
        Option("--level", help="Lowest level.", choices=tuple(LEVELS)[1:]),
    ] = "debug",
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a line.")] = False,
) -> None:
    """Print what nodes log on /rosout, as they print it themselves, until Ctrl-C.

    A node publishes its messages from its own level on; `teleopctl logger set` changes that level.
    """
    from teleopctl.cli.command_node import command_node
    from teleopctl.interfaces import get_message
    from teleopctl.node import SingleThreadedExecutor, qos_profile_rosout_default

    wanted = {_logger_of(absolute_name(name)) for name in node_names or ()}

    # Any: a message of rcl_interfaces, whose class is created at run time.
    def show(message: Any) -> None:
        is_wanted = not wanted or any(
            message.name == name or message.name.startswith(f"{name}.") for name in wanted
        )
        if message.level >= LEVELS[level] and is_wanted:
            _print(message, as_json=as_json)

    with command_node() as node, SingleThreadedExecutor(context=node.context) as executor:
        node.create_subscription(
            get_message("rcl_interfaces/msg/Log"), "/rosout", show, qos_profile_rosout_default
        )
        executor.add_node(node)
        executor.spin()


_COLOURS = {"DEBUG": "\x1b[32m", "WARN": "\x1b[33m", "ERROR": "\x1b[31m", "FATAL": "\x1b[31m"}


# Any: as above.
def _print(message: Any, *, as_json: bool) -> None:
    severity = _NAMES.get(message.level, str(message.level))
    if as_json:
        stamp = {"sec": message.stamp.sec, "nanosec": message.stamp.nanosec}
        document = {"stamp": stamp, "level": severity, "name": message.name, "msg": message.msg}
        console.out_json(document, compact=True)
    else:
        stamp_text = f"{message.stamp.sec}.{message.stamp.nanosec:09d}"
        line = f"[{severity}] [{stamp_text}] [{message.name}]: {message.msg}"
        console.out_coloured((line, _COLOURS.get(severity, "")))
    console.flush()


def _logger_of(node: str) -> str:
    """Return the name of a node's logger: ``left.talker`` for ``/left/talker``."""
    return node.lstrip("/").replace("/", ".")


def _shown(level: str | None) -> str:
    return "no response" if level is None else level


class _Loggers:
    """Client of the logger services of the nodes in the graph, in a session of its own."""

    def __init__(self) -> None:
        from teleopctl.wire import open_session, query_graph

        self._session = open_session("client")
        self.graph: Graph = query_graph(self._session)

    def __enter__(self) -> "_Loggers":
        return self

    def __exit__(self, *_: object) -> None:
        from teleopctl.wire import close_session

        close_session(self._session)

    def offers(self, node: str) -> bool:
        """Return whether a node has the services."""
        return bool(self.graph.servers(f"{node}/{_GET}"))

    def find(self, name: str) -> str:
        """Return the full name of a node with the services.

        Raises:
            NotFoundError: There is no such node, or it has no such services.
        """
        node = absolute_name(name)
        if self.graph.find_node(node) is None:
            hint = did_you_mean(node, self.graph.node_names())
            raise NotFoundError(f"Unable to find node '{node}'", hint=hint)
        if not self.offers(node):
            raise NotFoundError(f"'{node}' has no services for its logger levels", hint=_HOW)
        return node

    def levels(self, loggers: dict[str, str], *, strict: bool = False) -> dict[str, str | None]:
        """Return the level of a logger of each node, by node; None for one that does not respond.

        Args:
            loggers: Name of the logger by node.
            strict: Whether a node that does not respond is an error.
        """
        found: dict[str, str | None] = {}
        # Any: fields of a request.
        requests: dict[str, dict[str, list[Any]]] = {
            node: {"names": [logger]} for node, logger in loggers.items()
        }
        for node, answer in self._call("GetLoggerLevels", _GET, requests).items():
            if isinstance(answer, TeleopctlError):
                if strict:
                    raise answer
                found[node] = None
            else:
                level = answer.levels[0].level
                found[node] = _NAMES.get(level, str(level))
        return found

    def set(self, node: str, logger: str, level: int) -> None:
        """Set the level of a logger of a node.

        Raises:
            RefusedError: The node refuses it.
            UnavailableError: The node does not respond.
        """
        from teleopctl.interfaces import get_message

        entry = get_message("rcl_interfaces/msg/LoggerLevel")(name=logger, level=level)
        answer = self._call("SetLoggerLevels", _SET, {node: {"levels": [entry]}})[node]
        if isinstance(answer, TeleopctlError):
            raise answer
        (result,) = answer.results
        if not result.successful:
            raise RefusedError(f"'{node}' refuses the level: {result.reason}")

    # Any: responses of rcl_interfaces.
    def _call(self, kind: str, name: str, requests: "Mapping[str, dict[str, list[Any]]]") -> Any:
        from teleopctl.interfaces import get_service
        from teleopctl.wire import ServiceRequest, responses_of_nodes

        service = get_service(f"rcl_interfaces/srv/{kind}")
        return responses_of_nodes(
            {
                node: ServiceRequest(
                    self._session, service, f"{node}/{name}", service.Request(**fields)
                )
                for node, fields in requests.items()
            },
            _TIMEOUT_S,
        )
