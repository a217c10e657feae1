"""``teleopctl sim``: the running simulation, and sweeps of many runs."""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Self

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option, Verb, VerbGroup
from teleopctl.errors import NotFoundError, RefusedError, UnavailableError, UsageError

if TYPE_CHECKING:
    from teleopctl.sweep import RunRequest, RunResult, Sweep


GROUP = VerbGroup(
    "Run simulations.",
    {
        "pause": Verb(f"{__name__}:pause", "Pause the simulation."),
        "play": Verb(f"{__name__}:play", "Resume the simulation."),
        "step": Verb(f"{__name__}:step", "Advance a paused simulation by steps of physics."),
        "reset": Verb(f"{__name__}:reset", "Reset the simulation."),
        "list": Verb(f"{__name__}:list_entities", "List the entities of the simulation."),
        "spawn": Verb(
            f"{__name__}:spawn",
            "Add an object to the simulation.",
            examples=("teleopctl sim spawn can.urdf --at 0.3,1.2,0.5",),
        ),
        "delete": Verb(f"{__name__}:delete", "Remove an entity from the simulation."),
        "save": Verb(
            f"{__name__}:save",
            "Save the state of the simulation.",
            examples=("teleopctl sim save grasp", "teleopctl sim save grasp.json"),
        ),
        "load": Verb(f"{__name__}:load", "Load a saved state."),
        "sweep": Verb(
            f"{__name__}:sweep",
            "Run a launch file many times with varied parameters.",
            examples=(
                "teleopctl sim sweep sim.yaml camera:=false --grid mujoco_sim:mass_scale:=0.5,1,2 "
                "--duration 10 --measure '/joint_states/position[0]:max'",
                "teleopctl sim sweep --resume runs",
            ),
        ),
    },
)


# Longest wait for a response, in seconds; only many steps and compiling a model take long.
_LONGEST_WAIT_S = 60.0
_STANDARD, _MUJOCO = "simulation_interfaces/srv", "mujoco_ros2_control_msgs/srv"
_PLAYING, _PAUSED = 1, 2
_OK, _ALREADY = 1, 101

EntityName = Annotated[str, Argument(help="The entity, as `sim list` has it.")]
StateName = Annotated[
    str,
    Argument(
        metavar="NAME", help="Name under which the simulator keeps the state, or a .json file."
    ),
]


def pause(as_json: AsJson = False) -> None:
    """Pause the simulation."""
    _set_state(_PAUSED)
    _say("The simulation is paused", as_json)


def play(as_json: AsJson = False) -> None:
    """Resume the simulation."""
    _set_state(_PLAYING)
    _say("The simulation is running", as_json)


def step(
    steps: Annotated[int, Argument(metavar="N", help="Number of physics steps.")] = 1,
    as_json: AsJson = False,
) -> None:
    """Advance a paused simulation by steps of physics."""
    if steps < 1:
        raise UsageError(f"N is {steps}, expected at least 1")
    try:
        _standard("StepSimulation", steps=steps)
    except UnavailableError as error:
        error.hint = "The steps continue; `teleopctl sim pause` ends them."
        raise
    _say(f"Advanced by {steps} step{'s' if steps > 1 else ''}", as_json)


def reset(as_json: AsJson = False) -> None:
    """Reset time and states; spawned entities are removed, deleted ones restored."""
    _standard("ResetSimulation")
    _say("The simulation was reset", as_json)


def list_entities(as_json: AsJson = False) -> None:
    """List the entities of the simulation: robots and objects."""
    names = list(_standard("GetEntities").entities)
    if as_json:
        console.out_json(names)
        return
    for name in names:
        console.out(name)


def spawn(
    file: Annotated[
        str, Argument(metavar="FILE", help="A URDF, SDF, MJCF or YAML file, or a URI of one.")
    ],
    name: Annotated[
        str | None, Option("--name", help="Name of the entity; by default that in the file.")
    ] = None,
    at: Annotated[str | None, Option("--at", metavar="X,Y,Z", help="Position, in metres.")] = None,
    as_json: AsJson = False,
) -> None:
    """Add an object to the simulation; if its name is taken, a number is appended."""
    from teleopctl.interfaces import get_message, get_service

    request = get_service(f"{_STANDARD}/SpawnEntity").Request(name=name or "", allow_renaming=True)
    uri = file if "://" in file else str(Path(file).absolute())
    if hasattr(request, "uri"):
        request.uri = uri
    else:
        request.entity_resource = get_message("simulation_interfaces/msg/Resource")(uri=uri)
    if at is not None:
        position = request.initial_pose.pose.position
        position.x, position.y, position.z = _place(at)
    response = _checked(_send("SpawnEntity", _STANDARD, request))
    entity = str(response.entity_name)
    if response.result.error_message:
        console.note(f"'{entity}': {response.result.error_message}")
    parts = [] if as_json else _parts_of(entity)
    console.out_done(f"Spawned {', '.join(parts)}", as_json=as_json, entity=entity)


def delete(entity: EntityName, as_json: AsJson = False) -> None:
    """Remove an entity from the simulation."""
    _standard("DeleteEntity", entity=entity)
    console.out_done(f"Deleted {entity}", as_json=as_json, entity=entity)


def save(name: StateName, as_json: AsJson = False) -> None:
    """Save the state of the simulation, to go back to it with `sim load`."""
    _say(_world("save_world", name), as_json)


def load(name: StateName, as_json: AsJson = False) -> None:
    """Load a saved state, or a keyframe of an MJCF file."""
    _say(_world("reset_world", name), as_json)


def _say(message: str, as_json: bool) -> None:
    console.out_done(message, as_json=as_json, message=message)


def _parts_of(entity: str) -> list[str]:
    """Return the names of a spawned entity, or of the several entities of its file."""
    names = _standard("GetEntities").entities
    return [entity] if entity in names else [n for n in names if n.startswith(f"{entity}/")]


def _place(text: str) -> list[float]:
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 3:
        raise UsageError(f"--at is '{text}', expected three numbers: --at=1,-0.5,0.3")
    return numbers


def _set_state(wanted: int) -> None:
    from teleopctl.interfaces import get_message, get_service

    state = get_message("simulation_interfaces/msg/SimulationState")(state=wanted)
    request = get_service(f"{_STANDARD}/SetSimulationState").Request(state=state)
    response = _send("SetSimulationState", _STANDARD, request)
    if response.result.result != _ALREADY:
        _checked(response)


# Any, here and below: requests and responses, whose classes are created at run time.
def _standard(type_: str, **fields: object) -> Any:
    from teleopctl.interfaces import get_service

    return _checked(_send(type_, _STANDARD, get_service(f"{_STANDARD}/{type_}").Request(**fields)))


def _checked(response: Any) -> Any:
    if response.result.result != _OK:
        raise RefusedError(response.result.error_message or "The simulator rejected the request")
    return response


def _world(service: str, name: str) -> str:
    from teleopctl.interfaces import get_service

    keyframe = str(Path(name).absolute()) if "/" in name or name.endswith(".json") else name
    request = get_service(f"{_MUJOCO}/ResetWorld").Request(keyframe=keyframe)
    response = _send("ResetWorld", _MUJOCO, request, service)
    if not response.success:
        raise RefusedError(response.message)
    return str(response.message)


def _send(type_: str, package: str, request: Any, service: str = "") -> Any:
    """Call the simulator's service of a type, found in the graph; return the response."""
    from teleopctl.cli.command_node import brief_node
    from teleopctl.interfaces import get_service
    from teleopctl.wire import query_graph

    type_name = f"{package}/{type_}"
    with brief_node() as node:
        graph = query_graph(node.context.session)
        names = [
            name
            for name, types in graph.service_names_and_types()
            if type_name in types
            and (not service or name.endswith(f"/{service}"))
            and graph.servers(name, type_name)
        ]
        if not names:
            raise NotFoundError(
                "No running simulator offers this service",
                hint="Start one: teleopctl launch sim.yaml",
            )
        client = node.create_client(get_service(type_name), min(names))
        response = client.call_async(request).wait_for_response(_LONGEST_WAIT_S)
    if response is None:
        raise UnavailableError(f"'{min(names)}' did not answer within {_LONGEST_WAIT_S:g} s")
    return response


_WIDTH = 30
_CLEAR_LINE = "\r\x1b[2K"


class SweepProgress:
    """Progress of a sweep on stderr: a bar on a terminal, else a line for each finished run.

    Args:
        count: Number of all runs.
        done: Number of runs that were done before.
        on_terminal: Whether stderr is a terminal.
    """

    def __init__(self, count: int, done: int, *, on_terminal: bool) -> None:
        import time

        self._count = count
        self._done = done
        self._before = done
        self._failed = 0
        self._at_work = 0
        self._on_terminal = on_terminal
        self._started = time.monotonic()

    def __enter__(self) -> Self:
        self._draw()
        return self

    def __exit__(self, *_: object) -> None:
        if self._on_terminal:
            sys.stderr.write(_CLEAR_LINE)
            sys.stderr.flush()

    def begin(self) -> None:
        """Count one more run as started, and redraw the progress bar."""
        self._at_work += 1
        self._draw()

    def finish(self, result: "RunResult") -> None:
        """Count a finished run; redraw the bar or, without a terminal, print the result."""
        self._at_work -= 1
        self._done += 1
        self._failed += not result.is_done
        if not self._on_terminal:
            parameters = "".join(f" {name}={value}" for name, value in result.parameters.items())
            console.note(
                f"[{self._done}/{self._count}] run {result.number}{parameters}: {result.result} "
                f"after {result.wall_s:.1f} s"
            )
        self._draw()

    def _draw(self) -> None:
        import time

        if not self._on_terminal:
            return
        filled = _WIDTH * self._done // self._count
        text = f"[{'=' * filled}{' ' * (_WIDTH - filled)}] {self._done}/{self._count}"
        text += f", {self._at_work} at work"
        if self._failed:
            text += f", {self._failed} failed"
        if finished := self._done - self._before:
            spent_s = time.monotonic() - self._started
            left_s = round(spent_s / finished * (self._count - self._done))
            text += f", {left_s // 60}:{left_s % 60:02d} left"
        sys.stderr.write(_CLEAR_LINE + text)
        sys.stderr.flush()


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
        Option("--runs", "-n", help="Number of runs for each combination of the grids."),
    ] = None,
    seed: Annotated[int, Option("--seed", help="Seed of the random values.")] = 0,
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
            help="Time starts when this program of the launch file has ended.",
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
        int | None, Option("--jobs", "-j", help="Number of parallel runs; by default one per core.")
    ] = None,
    output: Annotated[
        str | None, Option("--output", "-o", metavar="FOLDER", help="Folder of the runs.")
    ] = None,
    cluster: Annotated[
        str | None,
        Option(
            "--cluster",
            metavar="ADDRESS",
            help="Dask scheduler whose workers execute the runs, such as tcp://server:8786.",
        ),
    ] = None,
    send: Annotated[
        str | None,
        Option(
            "--send",
            metavar="FOLDER",
            help="Folder to send to the workers; by default the launch file's package or folder.",
        ),
    ] = None,
    resume: Annotated[
        str | None,
        Option("--resume", metavar="FOLDER", help="Continue a sweep that was stopped."),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Run a launch file many times with varied parameters, as fast as the machine allows.

    Each run has its own graph, folder and bag. A run starts when everything is up, and ends after
    --duration or when the launch ends. The exit status is 1 if a run fails.
    """
    import time

    from teleopctl.sweep import Sweep

    if jobs is not None and jobs < 1:
        raise UsageError(f"--jobs is {jobs}, expected at least 1")
    if cluster is not None and jobs is not None:
        raise UsageError(
            "--jobs is for this machine",
            hint="On a cluster the workers set the number: dask worker --nthreads N ADDRESS",
        )
    if send is not None and cluster is None:
        raise UsageError("--send needs --cluster: local runs use the files directly")
    if resume is not None:
        varied = (words, grid, sample, runs, after, measure, output)
        times = (duration, timeout, stall_timeout)
        if any(each is not None for each in (*varied, *times)):
            raise UsageError(
                "--resume takes all settings from the folder",
                hint="Only --jobs, --cluster and --send can be combined with it.",
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
    """Return the requests of the runs, and the settings of the sweep for its record."""
    from teleopctl.cli.verbs.launch import parse_launch_words
    from teleopctl.launch import argument_names, find_launch_file, undeclared_argument_warnings
    from teleopctl.sweep import (
        RunRequest,
        combinations,
        launch_arguments,
        parse_grid,
        parse_measure,
        parse_sample,
    )

    package, name, arguments = parse_launch_words(words)
    file = find_launch_file(package, name)
    argument_names(file)  # raises here for an unreadable file, rather than in each run
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
    if wrong := undeclared_argument_warnings(file, launch_arguments(requests[0])):
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
    """Return the number of CPU cores that this process may use; all cores if unknown."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _run(work: "Sweep", jobs: int) -> None:
    with _progress(work, jobs) as progress:
        work.run(jobs, progress.begin, progress.finish)


def _run_on_cluster(work: "Sweep", address: str, folder: Path | None) -> None:
    from teleopctl.sweep import Cluster, not_sent, pack_launch

    first, cwd = work.requests[0], Path.cwd()
    sent_folder, data = pack_launch(Path(first.file), folder, cwd)
    values = [
        value
        for request in work.requests
        for value in (*request.arguments.values(), *request.parameters.values())
    ]
    for value in not_sent(values, sent_folder, cwd):
        console.note(f"{value} is not sent: each worker needs it at this path (or --send FOLDER)")
    with Cluster(address) as workers:
        if sent_folder.root:
            count = workers.workers
            console.note(f"{sent_folder.root} is sent to {count} worker{'' if count == 1 else 's'}")
        with _progress(work, workers.slots) as progress:
            workers.run(work, sent_folder, data, progress.begin, progress.finish)


def _progress(work: "Sweep", jobs: int) -> SweepProgress:
    count, left = len(work.requests), len(work.pending())
    done = count - left
    console.note(
        f"{left} {'run' if left == 1 else 'runs'}, {min(jobs, left)} at a time, into {work.folder}"
        + (f"; {done} done before" if done else "")
    )
    return SweepProgress(count, done, on_terminal=sys.stderr.isatty())


def _show(work: "Sweep", results: "list[RunResult]", *, as_json: bool) -> None:
    """Print the results of the runs as a table or as JSON, and notes on failed runs."""
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
