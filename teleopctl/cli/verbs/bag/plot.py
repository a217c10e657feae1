"""``teleopctl bag plot``."""

import math
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from teleopctl.base.extras import extra
from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import PictureFile
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.bag.options import BagPath
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from teleopctl.bag import Curve

_WIDTH, _HEIGHT = 80, 24


def plot(
    bag_path: BagPath,
    fields: Annotated[
        list[str],
        Argument(
            help="A topic and a field of it, such as /joint_states/position[0]; of an array, "
            "all elements.",
            metavar="FIELD...",
        ),
    ],
    output: PictureFile = None,
    start_offset: Annotated[
        float,
        Option("--start-offset", help="Seconds from the start of the bag.", metavar="SECONDS"),
    ] = 0.0,
    duration: Annotated[
        float, Option("--duration", help="Number of seconds to draw.", metavar="SECONDS")
    ] = math.inf,
) -> None:
    """Draw numbers of a bag over time.

    The time axis starts at the beginning of the bag and shows times of recording.
    """
    from teleopctl.bag import check_plot_file, open_bag, read_curves, save_plot

    if start_offset < 0.0 or not duration > 0.0:
        raise UsageError("A plot begins at 0 s or later, and takes more than 0 s")
    if output is not None:
        check_plot_file(Path(output))
    path = Path(bag_path)
    with open_bag(path) as bag:
        for remark in bag.remarks:
            console.warn(remark)
        curves = read_curves(bag, fields, start_offset, start_offset + duration)
    if output is None:
        _draw(curves)
    else:
        save_plot(curves, Path(output), path.resolve().name)


def _draw(curves: "Sequence[Curve]") -> None:
    from teleopctl.base.printable import printable_line
    from teleopctl.cli.verbs.topic.plot import line_plot_text, reduced_points

    with extra("tui", "uniplot"):
        import uniplot as uniplot
    times = [time_s for curve in curves for time_s in curve.times]
    first_s, last_s = min(times, default=0.0), max(times, default=0.0)
    if last_s <= first_s:
        last_s = first_s + 1.0
    width, height = shutil.get_terminal_size() if sys.stdout.isatty() else (_WIDTH, _HEIGHT)
    lines = [
        (
            printable_line(curve.name),
            *reduced_points(
                list(zip(curve.times, curve.values, strict=True)), first_s, last_s, width
            ),
        )
        for curve in curves
    ]
    text = line_plot_text(
        lines,
        (first_s, last_s),
        width,
        height - 1,
        colour=sys.stdout.isatty() and console.colour_enabled(sys.stdout),
    )
    console.out_drawing(text or "None of the values is a number")
