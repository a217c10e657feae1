"""``teleopctl doctor check``: runs all checks, or prints the reports."""

from collections.abc import Callable, Iterable, Iterator

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.doctor import checks, reports
from teleopctl.cli.verbs.doctor.findings import (
    Finding,
    Found,
    print_findings,
    print_findings_as_json,
)
from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.wire import Graph

_Check = Callable[[], Iterable[Finding]]


def check(
    report: Annotated[bool, Option("-r", "--report", help="Print all reports instead.")] = False,
    report_failed: Annotated[
        bool, Option("-rf", "--report-failed", help="Print reports of failed checks, too.")
    ] = False,
    exclude_packages: Annotated[
        bool, Option("-ep", "--exclude-packages", help="Leave packages out.")
    ] = False,
    include_warnings: Annotated[
        bool, Option("-iw", "--include-warnings", help="Let warnings fail a check.")
    ] = False,
    exit_status: Annotated[
        bool, Option("--exit-status", help="End with 1 when a check failed; ros2 ends with 0.")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Check the machine, the network and the graph for faults.

    Prints findings to stderr, with hints how to fix them.
    """
    if report and report_failed:
        raise UsageError("--report and --report-failed contradict each other")
    graph = _graph()
    if report:
        _print_reports(reports.REPORTS, graph or Graph(), exclude_packages)
        return 0
    chosen = _checks(graph, exclude_packages)
    failed: list[str] = []
    found: list[Found] = []
    for category, subject, one in chosen:
        findings = list(_careful(one))
        found += [Found(category, subject, finding) for finding in findings]
        if any(finding.is_error or include_warnings for finding in findings):
            failed.append(category)
    if as_json:
        print_findings_as_json(found, [subject for _, subject, _ in chosen])
    else:
        print_findings(found, failed, len(chosen))
        if report_failed and failed:
            _print_reports(dict.fromkeys(failed), graph or Graph(), exclude_packages)
    return int(exit_status and bool(failed))


def _graph() -> Graph | None:
    """Return the ROS graph; None without a router."""
    from teleopctl.cli.graph_lookup import live_graph

    try:
        return live_graph()
    except TeleopctlError:
        return None


def _checks(graph: Graph | None, exclude_packages: bool) -> list[tuple[str, str, _Check]]:
    """Return the checks, each with its category and its subject."""
    here: list[tuple[str, str, _Check]] = [
        ("network", "router", checks.check_router),
        ("platform", "drawing", checks.check_drawing),
        ("platform", "shared memory", checks.check_shared_memory),
        ("platform", "environment", checks.check_environment),
    ]
    if not exclude_packages:
        here.append(("package", "packages", checks.check_packages))
    if graph is None:
        return here
    return [
        *here,
        ("topic", "topics", lambda: checks.check_topics(graph)),
        ("middleware", "quality of service", lambda: checks.check_qos(graph)),
        ("middleware", "types", lambda: checks.check_types(graph)),
        ("node", "nodes", lambda: checks.check_nodes(graph)),
        ("clock", "clocks", lambda: checks.check_clocks(graph)),
    ]


def _careful(one: _Check) -> Iterator[Finding]:
    """Run a check and yield its findings; an error of the check is a finding too."""
    try:
        yield from one()
    except TeleopctlError as error:
        yield Finding(error.message, error.hint or "")


def _print_reports(categories: Iterable[str], graph: Graph, exclude_packages: bool) -> None:
    for category in categories:
        if category == "package" and exclude_packages:
            continue
        for make in reports.REPORTS.get(category, ()):
            console.out_lines(make(graph).lines())
