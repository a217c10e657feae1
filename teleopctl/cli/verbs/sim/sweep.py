"""``teleopctl sim sweep``: many runs of a launch file."""

import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.launch import split
from teleopctl.cli.verbs.sim.progress import SweepProgress
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from teleopctl.sweep import RunRequest, RunResult, Sweep


def sweep(
    words: Annotated[
        list[str] | None,
        Argument(
            metavar="[PACKAGE] FILE [NAME:=VALUE]...",
            help="A launch file and its arguments, the same in each run.",
            complete="launch_words",
        ),
    ] = None,
    grid: Annotated[
        list[str] | None,
        Option(
            "--grid",
            "-g",
            metavar="NAME:=VALUES",
            help="A launch argument, or NODE:PARAMETER, with each of its values: a,b,c or "
            "linspace(first,last,count).",
        ),
    ] = None,
    sample: Annotated[
        list[str] | None,
        Option(
            "--sample",
            "-s",
            metavar="NAME:=DISTRIBUTION",
            help="The same with random values: uniform(low,high), loguniform(low,high), "
            "normal(mean,deviation), integers(low,high) or choice(a,b,c).",
        ),
    ] = None,
    runs: Annotated[
        int | None,
        Option("--runs", "-n", help="How many runs of each combination of the grids."),
    ] = None,
    seed: Annotated[int, Option("--seed", help="Of the random values.")] = 0,
    duration: Annotated[
        float | None,
        Option("--duration", "-d", help="Simulated seconds after which a run ends."),
    ] = None,
    timeout: Annotated[
        float | None,
        Option("--timeout", help="Seconds after which a run has failed, its start included."),
    ] = None,
    stall_timeout: Annotated[
        float | None,
        Option(
            "--stall-timeout",
            help="Seconds without progress after which the start of a run has failed; 30.",
        ),
    ] = None,
    after: Annotated[
        list[str] | None,
        Option(
            "--after",
            metavar="EXECUTABLE",
            help="Time begins when this program of the launch file, which sends commands say, has "
            "ended.",
        ),
    ] = None,
    measure: Annotated[
        list[str] | None,
        Option(
            "--measure",
            "-m",
            metavar="FIELD[:HOW]",
            help="A number for the table, from the bag: last, first, min, max, absmax, mean, rms, "
            "range or count of a field.",
        ),
    ] = None,
    jobs: Annotated[
        int | None, Option("--jobs", "-j", help="How many runs at a time; one for each core.")
    ] = None,
    output: Annotated[
        str | None, Option("--output", "-o", metavar="FOLDER", help="Where the runs are kept.")
    ] = None,
    cluster: Annotated[
        str | None,
        Option(
            "--cluster",
            metavar="ADDRESS",
            help="The Dask scheduler whose workers do the runs, such as tcp://server:8786.",
        ),
    ] = None,
    send: Annotated[
        str | None,
        Option(
            "--send",
            metavar="FOLDER",
            help="What the runs on a cluster need; by default the launch file's package or folder.",
        ),
    ] = None,
    resume: Annotated[
        str | None,
        Option("--resume", metavar="FOLDER", help="Go on with a sweep that was stopped."),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Run a launch file many times with varied parameters, as fast as the machine allows.

    Each run has a graph, a folder and a bag of its own. It begins when everything is up, and ends
    after --duration, or when the launch ends. The exit status is 1 where a run has failed.
    """
    from teleopctl.sweep import Sweep

    if jobs is not None and jobs < 1:
        raise UsageError(f"--jobs is {jobs}, expected at least 1")
    if cluster is not None and jobs is not None:
        raise UsageError(
            "--jobs is for this machine",
            hint="On a cluster the workers say how many: dask worker --nthreads N ADDRESS",
        )
    if send is not None and cluster is None:
        raise UsageError("--send goes with --cluster: here all files are at hand")
    if resume is not None:
        varied = (words, grid, sample, runs, after, measure, output)
        times = (duration, timeout, stall_timeout)
        if any(each is not None for each in (*varied, *times)):
            raise UsageError(
                "--resume takes everything from the folder",
                hint="Only --jobs, --cluster and --send go with it.",
            )
        work = Sweep.open(Path(resume).absolute())
    else:
        requests, asked = _requests(
            words or [],
            *(grid or [], sample or [], runs, seed, duration, timeout, stall_timeout),
            *(after or [], measure or []),
        )
        folder = Path(output or time.strftime("sweep_%Y_%m_%d-%H_%M_%S")).absolute()
        work = Sweep.create(folder, requests, asked)
    try:
        if cluster is None:
            _run(work, jobs or _cores())
        else:
            _run_on_cluster(work, cluster, None if send is None else Path(send))
    finally:
        results = work.results()
        _show(work, results, as_json=as_json)
    return 0 if all(result.is_done for result in results) else 1


def _requests(
    words: list[str],
    grid: list[str],
    sample: list[str],
    runs: int | None,
    seed: int,
    duration: float | None,
    timeout: float | None,
    stall_timeout: float | None,
    after: list[str],
    measures: list[str],
) -> "tuple[list[RunRequest], dict[str, object]]":
    """What the runs are to be, and what was asked for."""
    from teleopctl.launch import argument_names, find_launch_file, undeclared_arguments
    from teleopctl.sweep import (
        RunRequest,
        combinations,
        launch_arguments,
        parse_grid,
        parse_measure,
        parse_sample,
    )

    package, name, arguments = split(words)
    file = find_launch_file(package, name)
    argument_names(file)  # one that cannot be read is better refused now than by each run
    grids, samples = [parse_grid(text) for text in grid], [parse_sample(text) for text in sample]
    if samples and runs is None:
        raise UsageError("How many samples?", hint="--runs 100")
    numbers = {"--runs": runs, "--duration": duration, "--timeout": timeout}
    for option, number in (numbers | {"--stall-timeout": stall_timeout}).items():
        if number is not None and not 0 < number < float("inf"):
            raise UsageError(f"{option} is {number:g}, expected a number above 0")
    names = [parse_measure(text).name for text in measures]
    requests = [
        RunRequest(
            number=number,
            file=str(file.absolute()),
            arguments=arguments,
            parameters=parameters,
            duration_s=duration,
            timeout_s=timeout,
            stall_timeout_s=stall_timeout,
            after=after,
            measures=names,
        )
        for number, parameters in enumerate(combinations(grids, samples, runs or 1, seed), 1)
    ]
    if wrong := undeclared_arguments(file, launch_arguments(requests[0])):
        raise UsageError(wrong[0])
    return requests, {
        "file": str(file.absolute()),
        "arguments": dict(arguments),
        "grid": list(grid),
        "sample": list(sample),
        "runs": runs or 1,
        "seed": seed,
        "duration": duration,
        "timeout": timeout,
        "stall_timeout": stall_timeout,
        "after": list(after),
        "measures": list(names),
    }


def _cores() -> int:
    """How many processor cores this process may use; all, where the system does not tell."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _run(work: "Sweep", jobs: int) -> None:
    with _progress(work, jobs) as progress:
        work.run(jobs, progress.begin, progress.tell)


def _run_on_cluster(work: "Sweep", address: str, folder: Path | None) -> None:
    from teleopctl.sweep import Cluster, make_parcel, not_sent

    first, cwd = work.requests[0], Path.cwd()
    parcel, data = make_parcel(Path(first.file), folder, cwd)
    values = [
        value
        for request in work.requests
        for value in (*request.arguments.values(), *request.parameters.values())
    ]
    for value in not_sent(values, parcel, cwd):
        console.note(f"{value} is not sent: each worker needs it at that place (or --send FOLDER)")
    with Cluster(address) as workers:
        if parcel.root:
            count = workers.workers
            console.note(f"{parcel.root} is sent to {count} worker{'' if count == 1 else 's'}")
        with _progress(work, workers.slots) as progress:
            workers.run(work, parcel, data, progress.begin, progress.tell)


def _progress(work: "Sweep", jobs: int) -> SweepProgress:
    count, left = len(work.requests), len(work.left())
    done = count - left
    console.note(
        f"{left} {'run' if left == 1 else 'runs'}, {min(jobs, left)} at a time, into {work.folder}"
        + (f"; {done} done before" if done else "")
    )
    return SweepProgress(count, done, on_terminal=sys.stderr.isatty())


def _show(work: "Sweep", results: "list[RunResult]", *, as_json: bool) -> None:
    """The table of what came of the runs."""
    for result in results:
        if result.error:
            console.note(f"Run {result.number}: {result.error}; see {result.folder}")
    if left := _left(work, results):
        console.note(f"{left} left: teleopctl sim sweep --resume {work.folder}")
    if as_json:
        from dataclasses import asdict

        runs = [asdict(result) for result in results]
        console.out_json({"folder": str(work.folder), "runs": runs, "left": _left(work, results)})
        return
    if not results:
        return
    parameters = list(dict.fromkeys(name for result in results for name in result.parameters))
    measures = list(dict.fromkeys(name for result in results for name in result.measures))
    machines = ["machine"] if any(result.machine for result in results) else []
    rows = [
        ["run", *parameters, "result", "simulated s", "wall s", *measures, *machines],
        *(
            [
                str(result.number),
                *(result.parameters.get(name, "") for name in parameters),
                result.result,
                _number(result.simulated_s),
                f"{result.wall_s:.1f}",
                *(_number(result.measures.get(name)) for name in measures),
                *(result.machine for _ in machines),
            ]
            for result in results
        ),
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    console.out_lines(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )


def _left(work: "Sweep", results: "list[RunResult]") -> int:
    return len(work.requests) - len(results)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.6g}"
