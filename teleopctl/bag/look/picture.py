"""Curves as a picture file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from teleopctl.bag.look.curves import Curve
from teleopctl.base.extras import extra
from teleopctl.base.printable import printable_line
from teleopctl.errors import SystemFailureError, UsageError

SUFFIXES = (".png", ".svg", ".pdf")

_WIDTH_IN, _HEIGHT_IN = 10.0, 5.0
_LEGEND_ROW_IN = 0.22
_DOTS_PER_IN = 120
# Fewer points are drawn one by one too, since a line shows not where they are.
_FEW_POINTS = 40


def check_picture_name(file: Path) -> None:
    """Raise if no plot can be written to a file of this name.

    Raises:
        UsageError: It does not end as a picture.
    """
    if file.suffix.lower() not in SUFFIXES:
        raise UsageError(f"'{file}' must end in {', '.join(SUFFIXES)}")


def save_picture(curves: Sequence[Curve], file: Path, title: str = "") -> None:
    """Write a plot of curves over seconds, with a legend.

    In an SVG, texts stay texts, and each curve is an element whose ``id`` is its name.

    Args:
        curves: The curves.
        file: PNG, SVG or PDF, by its suffix.
        title: What stands above.

    Raises:
        UsageError: The file's name does not end as a picture.
        MissingExtraError: matplotlib is not installed.
        SystemFailureError: The file cannot be written.
    """
    check_picture_name(file)
    with extra("plot", "matplotlib"):
        import matplotlib as mpl
        from matplotlib.figure import Figure
    colours = mpl.color_sequences["tab10" if len(curves) <= 10 else "tab20"]
    # The same picture has the same bytes; no text is taken for TeX.
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "bag", "text.parse_math": False}):
        height_in = _HEIGHT_IN + _LEGEND_ROW_IN * len(curves)
        figure = Figure((_WIDTH_IN, height_in), layout="constrained")
        axes = figure.add_subplot()
        for curve, colour in zip(curves, colours, strict=False):
            marker = "." if len(curve.times) <= _FEW_POINTS else ""
            name = printable_line(curve.name)
            (line,) = axes.plot(
                curve.times, curve.values, color=colour, linewidth=1.2, marker=marker
            )
            line.set_gid(name)
            line.set_label(f" {name}" if name.startswith("_") else name)
        axes.set_xlabel("Seconds since the start of the bag")
        axes.grid(visible=True, alpha=0.3)
        axes.margins(x=0.01)
        if title:
            axes.set_title(printable_line(title))
        figure.legend(loc="outside lower left", frameon=False, fontsize="small")
        try:
            # Without a date, for the same reason.
            metadata = None if file.suffix.lower() == ".png" else _without_date(file)
            figure.savefig(file, dpi=_DOTS_PER_IN, metadata=metadata)
        except OSError as error:
            raise SystemFailureError(f"Cannot write {file}: {error.strerror or error}") from error


def _without_date(file: Path) -> dict[str, None]:
    return {"CreationDate" if file.suffix.lower() == ".pdf" else "Date": None}
