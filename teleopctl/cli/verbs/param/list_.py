"""``teleopctl param list``."""

import re
from collections.abc import Sequence

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.param.graph_parameters import LONGEST_WAIT_S, Parameters
from teleopctl.cli.verbs.param.options import ServiceTimeout, Timeout
from teleopctl.cli.verbs.param.text import type_name
from teleopctl.cli.words.patterns import is_pattern
from teleopctl.errors import TeleopctlError, UsageError


def list_parameters(
    node_name: Annotated[
        str | None,
        Argument(help="The node, or a pattern; otherwise all nodes.", complete="nodes"),
    ] = None,
    show_types: Annotated[
        bool, Option("--param-type", help="Show the type of each parameter.")
    ] = False,
    include_hidden: Annotated[
        bool, Option("--include-hidden-nodes", help="Ask nodes whose name starts with _, too.")
    ] = False,
    name_filter: Annotated[
        str | None,
        Option("--filter", help="List only names that begin with this regular expression."),
    ] = None,
    prefixes: Annotated[
        list[str] | None,
        Option("--param-prefixes", help="List only what is below these.", metavar="PREFIX..."),
    ] = None,
    timeout: Timeout = 0.0,
    service_timeout: ServiceTimeout = LONGEST_WAIT_S,
    as_json: AsJson = False,
) -> int:
    """List parameters."""
    wanted = _pattern(name_filter)
    is_one = node_name is not None and not is_pattern(node_name)
    with Parameters(timeout, service_timeout) as parameters:
        nodes = (
            parameters.meant(node_name, include_hidden=include_hidden)
            if node_name
            else parameters.nodes(include_hidden=include_hidden)
        )
        answers = parameters.ask_all(nodes, "ListParameters", prefixes=prefixes or [])
        names = {
            node: sorted(name for name in answer.result.names if wanted.match(name))
            for node, answer in answers.items()
            if not isinstance(answer, TeleopctlError)
        }
        types = (
            {node: _types(parameters, node, names[node]) for node in names} if show_types else {}
        )
    if as_json:
        console.out_json({node: types.get(node) or names[node] for node in names})
    else:
        for node, its_names in names.items():
            if its_names and not is_one:
                console.out(f"{node}:")
            console.out_lines(_lines(its_names, types.get(node, {})))
    console.flush()
    failures = [answer for answer in answers.values() if isinstance(answer, TeleopctlError)]
    if is_one and failures:
        raise failures[0]
    for failure in failures:
        console.warn(failure.message)
    return 0


def _lines(names: Sequence[str], types: dict[str, str]) -> list[str]:
    return [f"  {name} (type: {types[name]})" if name in types else f"  {name}" for name in names]


def _types(parameters: Parameters, node: str, names: list[str]) -> dict[str, str]:
    response = parameters.ask(node, "GetParameterTypes", names=names)
    return dict(zip(names, map(type_name, response.types), strict=False))


def _pattern(text: str | None) -> re.Pattern[str]:
    try:
        return re.compile(text or "")
    except re.error as error:
        raise UsageError(f"'{text}' is no regular expression: {error}") from error
