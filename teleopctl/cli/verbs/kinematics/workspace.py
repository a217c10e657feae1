"""``teleopctl kinematics workspace``: the tool's reachable positions, as numbers and picture."""

from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.kinematics.source import RobotOptions, arm_of, read_robot, sorted_words
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy as np
    import numpy.typing as npt

    from teleopctl.kinematics import Arm, Workspace

    Array = npt.NDArray[np.float64]

# Size of a view on the terminal, in characters, which are twice as high as wide.
_COLUMNS, _ROWS = 36, 18
_SHADES = " ·░▒▓█"
_PICTURES = (".png", ".svg", ".pdf")
# Views: name, horizontal and vertical axis.
_VIEWS = (("from above", 0, 1), ("from the side", 0, 2))


def workspace(
    words: Annotated[
        list[str] | None,
        Argument(
            help="Robot's file with arguments of its xacro, or none for the running robot.",
            metavar="[FILE [name:=value]…]",
            complete="files",
        ),
    ] = None,
    samples: Annotated[
        int, Option("--samples", help="Number of random joint positions.", metavar="NUMBER")
    ] = 20_000,
    allow_collisions: Annotated[
        bool, Option("--allow-collisions", help="Keep positions at which links touch.")
    ] = False,
    output: Annotated[
        str | None,
        Option(
            "-o",
            "--output",
            help="Write a picture: PNG, SVG or PDF, by the file name.",
            metavar="FILE",
        ),
    ] = None,
    *,
    robot: RobotOptions,
    as_json: AsJson = False,
) -> None:
    """Draw the tool's positions at random joint positions, and print the extents.

    Positions at which links touch are left out. The picture is coloured by manipulability, which is
    low near singularities and at the border.
    """
    found = sorted_words(words or ())
    if found.numbers or found.joints or found.names:
        raise UsageError("A workspace takes a robot's file and arguments of its xacro only")
    if output is not None:
        _check_output(output)
    arm = arm_of(read_robot(found, robot, needs_state=False), robot)
    reached = arm.workspace(samples, collisions=allow_collisions)
    if output is not None:
        _save(arm, reached, Path(output))
    if as_json:
        console.out_json(
            {
                "group": arm.group.name,
                "tip": arm.group.tip,
                "frame": arm.model.description.root,
                "samples": reached.samples,
                "colliding": reached.colliding,
                "lower": dict(zip("xyz", reached.lower.tolist(), strict=True)),
                "upper": dict(zip("xyz", reached.upper.tolist(), strict=True)),
                "origin": dict(zip("xyz", reached.origin.tolist(), strict=True)),
                "reach_m": reached.reach_m,
            }
        )
        return
    if output is None:
        console.out_lines(_drawing(reached))
    console.out_lines(_extents(arm, reached))
    if output is not None:
        console.out(output)


def _extents(arm: "Arm", reached: "Workspace") -> "Iterator[str]":
    yield f"Workspace of '{arm.group.tip}' in '{arm.model.description.root}'"
    for axis, lower, upper in zip("xyz", reached.lower, reached.upper, strict=True):
        yield f"{axis}: {lower:.3f} to {upper:.3f} m"
    yield f"reach: {reached.reach_m:.3f} m from the axis of '{arm.names[0]}'"
    part = 100.0 * reached.colliding / reached.samples
    yield f"links touch at {part:.1f} % of {reached.samples} random joint positions"


def _drawing(reached: "Workspace") -> "Iterator[str]":
    """Yield the views beside each other: histograms of the tool's positions."""
    import numpy as np

    pictures = []
    for name, across, up in _VIEWS:
        low, high = reached.lower[[across, up]], reached.upper[[across, up]]
        # Square: the same scale along both axes.
        middle, half = 0.5 * (low + high), 0.5 * max(float((high - low).max()), 1e-3) * 1.001
        counts, _, _ = np.histogram2d(
            reached.points[:, across],
            reached.points[:, up],
            bins=(_COLUMNS, _ROWS),
            range=[(middle[0] - half, middle[0] + half), (middle[1] - half, middle[1] + half)],
        )
        most = float(np.percentile(counts[counts > 0], 90))
        levels = np.ceil(np.minimum(counts / most, 1.0) * (len(_SHADES) - 1)).astype(int)
        rows = ["".join(_SHADES[level] for level in row) for row in levels.T[::-1]]
        axes = f"{name}: {'xyz'[across]} to the right, {'xyz'[up]} up, {2 * half:.2f} m"
        pictures.append([*rows, axes])
    for left, right in zip(*pictures, strict=True):
        yield f"{left:{_COLUMNS + 6}}  {right}".rstrip()


def _check_output(output: str) -> None:
    if Path(output).suffix.lower() not in _PICTURES:
        raise UsageError(
            f"A picture is a file {', '.join(f'*{each}' for each in _PICTURES)}, not {output}"
        )
    if not Path(output).absolute().parent.is_dir():
        raise UsageError(f"There is no folder {Path(output).absolute().parent}")
    from teleopctl.base.extras import extra

    with extra("plot", "matplotlib"):
        import matplotlib as matplotlib


def _save(arm: "Arm", reached: "Workspace", file: Path) -> None:
    """Write both views, coloured by manipulability, with the arm at its positions."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 4.6), layout="constrained")
    chain = _chain(arm)
    shaded = None
    # The lowest last, so that singular places are visible.
    order = reached.manipulability.argsort()[::-1]
    for number, (name, across, up) in enumerate(_VIEWS, 1):
        axes = figure.add_subplot(1, len(_VIEWS), number)
        shaded = axes.scatter(
            reached.points[order, across],
            reached.points[order, up],
            c=reached.manipulability[order],
            s=3.0,
            linewidths=0.0,
            rasterized=True,
        )
        axes.plot(
            chain[:, across], chain[:, up], "o-", color="black", linewidth=2.0, markersize=4.0
        )
        axes.set_aspect("equal")
        axes.set_xlabel(f"{'xyz'[across]} (m)")
        axes.set_ylabel(f"{'xyz'[up]} (m)")
        axes.set_title(name)
    assert shaded is not None
    figure.colorbar(shaded, ax=figure.axes, label="manipulability", shrink=0.8)
    figure.suptitle(f"{arm.model.description.name}: '{arm.group.tip}' by group '{arm.group.name}'")
    figure.savefig(file, dpi=100)


def _chain(arm: "Arm") -> "Array":
    """Return the origins of the arm's joints and of its tool, (n + 1, 3), in the root's frame."""
    import numpy as np

    tool = arm.fk()[:3, 3]
    return np.array([*(arm.model.joint_origin(name) for name in arm.names), tool])
