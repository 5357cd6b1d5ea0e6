"""A figure in the package's style, or a user's axes; what every figure writes around its panels."""

from __future__ import annotations

from .canvas import BASE, COLUMN, DOTS, LEAST, STYLE, UNDATED, figure_style, keep  # isort: skip
from .canvas import styled, unchanged  # isort: skip

import io
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import wraps
from inspect import signature
from pathlib import Path
from typing import Any, ParamSpec

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cbook import is_math_text
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.textpath import text_to_path
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from ..base.checks import positive
from ..base.citation import joined, keys_of
from ..base.errors import ParameterError, shown
from ..base.quantities import Quantity, formula_in_latex, in_latex, plain_text
from ..base.types import Overwrite
from ..storage.origin import PACKAGE, origin_of
from ..storage.targets import PICTURES, check_suffix

_Arguments = ParamSpec("_Arguments")
LARGEST = 40.0
"""Largest width [in] and size of text [pt]."""
SCREEN = 144.0
"""Dots of a page for an inch of a figure: text of 7.5 points is small on a screen at 96."""


class _Canvas(FigureCanvasAgg):
    """A canvas that reads and measures each text once, for the layout and for the drawing."""

    parser: Any = None
    """Reads the formulas of all figures, since what it has read is remembered by parser."""

    def get_renderer(self) -> Any:
        """The renderer, with the common parser."""
        renderer: Any = super().get_renderer()  # type: ignore[no-untyped-call]
        _Canvas.parser = renderer.mathtext_parser = _Canvas.parser or renderer.mathtext_parser
        return renderer


class StyledFigure(Figure):
    """A figure that keeps its settings when it is drawn and saved: ticks and fonts are made then.

    `savefig` of Matplotlib would write the fonts of a PDF as outlines (Type 3), which journals
    refuse.
    """

    origin: Mapping[str, str] | None = None
    """The record of the call that drew the figure; its files carry it."""
    citation = ""
    """Keys of the works to cite, for `stability.citation`."""
    changed = False
    """Whether code of the user has drawn on it, by which that call does not say all."""

    def __init__(self, *args: Any, settings: Mapping[Any, Any] = STYLE, **options: Any) -> None:
        self.settings = dict(settings)
        with figure_style(self.settings):
            super().__init__(*args, **options)
        _Canvas(self)

    def __setattr__(self, name: str, value: Any) -> None:
        """Matplotlib sets `stale` at every change of the figure and of all that it holds."""
        super().__setattr__(name, value)
        if name == "stale" and value:
            super().__setattr__("changed", True)

    def remember(self, call: str, arguments: Mapping[str, Any], citation: str) -> None:
        """Keep the call that drew the figure, and what to cite."""
        self.citation = citation
        self.origin = origin_of(call, arguments, citation)
        self.changed = False

    def draw(self, renderer: Any) -> None:
        """Draw in the figure's own settings."""
        with figure_style(self.settings), unchanged(self):
            super().draw(renderer)

    def savefig(self, fname: Any, *, overwrite: Overwrite = True, **options: Any) -> None:
        """Save in the figure's own settings, as `Figure.savefig` does.

        Parameters
        ----------
        fname
            File to write.
        overwrite
            Whether an existing file may be replaced; "same": if the same call wrote it.
        **options
            As for `Figure.savefig`.
        """
        with figure_style(self.settings), unchanged(self):
            if overwrite is True and Path(str(fname)).suffix.lower() not in PICTURES:
                super().savefig(fname, **options)
                return
            name = check_suffix(fname, PICTURES)
            suffix, content = name.suffix.lower(), io.BytesIO()
            usual = {"format": suffix[1:], "metadata": UNDATED.get(suffix)}
            super().savefig(content, **usual | options)
        keep(self, name, content.getvalue(), overwrite, options)

    def _repr_mimebundle_(self, **_: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """The picture in a notebook, sharp, whether or not pyplot is imported there."""
        kept = io.BytesIO()
        self.savefig(kept, format="png", dpi=2 * SCREEN)
        wide, tall = (round(SCREEN * side) for side in self.get_size_inches())
        return {"image/png": kept.getvalue()}, {"image/png": {"width": wide, "height": tall}}


def remembered(plot: Callable[_Arguments, Figure]) -> Callable[_Arguments, Figure]:
    """A function that draws, whose figures know the call that drew them and what to cite."""
    # the version says nothing of what a function of the user draws
    theirs = not plot.__module__.startswith(f"{PACKAGE}.")

    @wraps(plot)
    def call(*args: _Arguments.args, **named: _Arguments.kwargs) -> Figure:
        figure = plot(*args, **named)
        if isinstance(figure, StyledFigure):
            arguments = signature(plot).bind(*args, **named).arguments
            keys = joined(filter(None, [figure.citation, *map(keys_of, arguments.values())]))
            if arguments.get("ax") is None:
                figure.remember(plot.__name__, arguments, keys)
                figure.changed = theirs
            figure.citation = keys
        return figure

    return call


@contextmanager
def drawing(
    ax: Any, width: float | None, fontsize: float | None, aspect: Callable[[float], float]
) -> Iterator[Figure]:
    """The figure to draw on, in the package's style: a new one, or that of the axes.

    Parameters
    ----------
    ax
        Axes of a user, or None for a figure of its own.
    width
        Width of a figure of its own [in]; one journal column when left out.
    fontsize
        Size of text [pt]; when left out 7.5, and on a user's axes that of the user's settings.
    aspect
        Height from width [in].

    Raises
    ------
    ParameterError
        If a size is not accepted, or a width is given with axes.
    """
    size = None if fontsize is None else checked_size("fontsize", fontsize, LEAST, "points")
    if ax is None:
        wide = COLUMN if width is None else checked_size("width", width, 2.0, "inches")
        settings = styled(BASE if size is None else size)
        with figure_style(settings):
            figure = StyledFigure(
                figsize=(wide, aspect(wide)), layout="constrained", settings=settings
            )
            spacing(figure, hspace=0.02, h_pad=0.02, w_pad=0.02)
            shown_at, figure.dpi = figure.dpi, DOTS  # measured as it is saved
            yield figure
            figure.dpi = shown_at
        return
    if width is not None:
        raise ParameterError("width belongs to a figure of its own; leave it out, or leave out ax.")
    base = float(matplotlib.rcParams["font.size"]) if size is None else size
    with matplotlib.rc_context(styled(max(base, LEAST))):
        for axes in panels(ax):
            axes.tick_params(labelsize=matplotlib.rcParams["xtick.labelsize"])
            for text in (axes.xaxis.label, axes.yaxis.label):
                text.set_fontsize(matplotlib.rcParams["axes.labelsize"])
        first: Any = panels(ax)[0]
        figure = first.get_figure(root=True)
        yield figure


def panels(ax: Any) -> list[Axes]:
    """The axes that a user gives, one or several.

    Raises
    ------
    ParameterError
        If they are none.
    """
    axes = [ax] if isinstance(ax, Axes) else ax
    row = list(axes.flat) if isinstance(axes, np.ndarray) else axes
    if (
        not isinstance(row, (list, tuple))
        or not row
        or not all(isinstance(panel, Axes) for panel in row)
    ):
        raise ParameterError(f"ax is {shown(ax)}; give axes of Matplotlib.")
    return list(row)


STRIP = 0.075
"""Height of a strip next to a panel, over that of the panel."""


def with_strips(figure: Figure, *, above: bool = False, below: bool = False) -> list[Axes]:
    """Panels from the top: the main one, with the strips next to it."""
    heights = [STRIP] * above + [1.0] + [STRIP] * below
    grid = {"height_ratios": heights, "hspace": 0.05}
    rows = figure.subplots(len(heights), 1, sharex=True, squeeze=False, gridspec_kw=grid)
    return [row[0] for row in rows]


def label_axes(main: Axes, rows: Sequence[Axes], x: str, y: str) -> None:
    """Labels and ticks of a panel; those of its x axis are under the lowest row."""
    whole: Any = main.get_figure(root=True)
    box = whole.bbox if isinstance(whole, StyledFigure) else main.get_window_extent()
    larger = matplotlib.rcParams["axes.labelsize"] / small() / points(main)
    for set_label, text, room in (
        (rows[-1].set_xlabel, x, 0.9 * box.width),
        (main.set_ylabel, y, 0.6 * box.height),
    ):

        def fits(line: str, room: float = room) -> bool:
            return bool(larger * wide(line) <= room)

        label = broken(text, fits, "  ")
        lines = label.split("\n")  # the law of a coefficient has a line of its own in small axes
        set_label("\n".join(n if fits(n) else broken(n, fits, " of ") for n in lines))
    if main.get_xscale() != "log":
        ticks_along(main.xaxis)
    if main.get_yscale() != "log":
        ticks_along(main.yaxis)
    for panel in rows[:-1]:
        panel.tick_params(axis="x", labelbottom=False)


class _EndTicks(MaxNLocator):
    """Round numbers, and both ends of the axis."""

    def tick_values(self, vmin: float, vmax: float) -> Any:
        low, high = sorted((vmin, vmax))
        room = 0.1 * (high - low)
        inner = np.asarray(super().tick_values(vmin, vmax))
        return [low, *inner[(inner > low + room) & (inner < high - room)], high]


class _EndFormatter(ScalarFormatter):
    """Round numbers with the digits that they need, and the ends with three."""

    def set_locs(self, locs: Any) -> None:
        """Take the digits from the round numbers."""
        super().set_locs(locs[1:-1] if len(locs) > 2 else locs)

    def __call__(self, x: float, pos: Any = None) -> str:
        """The number as text."""
        text = super().__call__(x, pos)
        low, high = self.axis.get_view_interval()  # type: ignore[union-attr]
        rest = abs(round(x, len(text.partition(".")[2])) - x)
        if self.get_offset() or x not in (low, high) or rest <= 1e-9 * abs(x):
            return text
        return self.fix_minus(f"{x:.3g}")


def ticks_along(axis: Any) -> None:
    """Ticks of an axis: both ends and a few between, and as a user's axes find room for."""
    if isinstance(axis.axes.get_figure(root=True), StyledFigure):
        axis.set_major_locator(_EndTicks(6, steps=[1, 2, 2.5, 5, 10]))
        axis.set_major_formatter(_EndFormatter())
    else:
        axis.set_major_locator(MaxNLocator("auto", steps=[1, 2, 2.5, 5, 10]))


def settle(figure: Figure) -> None:
    """Give the panels of a figure their room, which words and keys ask for."""
    engine = figure.get_layout_engine()
    if engine is not None and isinstance(figure, StyledFigure):
        engine.execute(figure)


def checked_size(name: str, value: Any, low: float, unit: str) -> float:
    """A size of at most `LARGEST`, or an error that says what is accepted."""
    number = positive(name, value)
    if not isinstance(number, float) or not low <= number <= LARGEST:
        raise ParameterError(f"{name} is {shown(value)}; give {low:g} to {LARGEST:g} {unit}.")
    return number


def checked_title(title: Any) -> str:
    """A title, or an error where Matplotlib could not draw it."""
    if not isinstance(title, str):
        raise ParameterError(f"title is {shown(title)}; give a text.")
    if is_math_text(title):
        try:
            text_to_path.mathtext_parser.parse(title)
        except ValueError as error:
            reason = str(error).strip().splitlines()[-1].split("  (")[0].split(": ", 1)[-1]
            raise ParameterError(
                f"title is {shown(title)}, which Matplotlib cannot read as a formula ({reason}); "
                r"write a dollar sign that begins none as \$."
            ) from None
    return title


def small() -> float:
    """Size of the smallest text in the current style [pt]."""
    return float(matplotlib.rcParams["legend.fontsize"])


def signed_ticks(
    place: Callable[[float], float], low: float, high: float, least: float, gap: float
) -> tuple[list[float], list[str]]:
    """Powers of ten of both signs and zero, so far apart that their labels do not touch.

    Parameters
    ----------
    place
        From a value to its place along the axis [pt].
    low, high
        Ends of the axis.
    least
        Smallest power of ten to label.
    gap
        Least distance of two ticks [pt].

    Returns
    -------
    ticks, labels
    """
    ticks = {0.0: place(0.0)} if low <= 0 <= high else {}
    for sign, end in ((1, high), (-1, -low)):
        power = math.floor(math.log10(end) + 1e-9) if end > 0 else -400
        while power >= round(math.log10(least)):
            spot = place(sign * 10.0**power)
            if all(abs(spot - other) >= gap for other in ticks.values()):
                ticks[sign * 10.0**power] = spot
            power -= 1
    return sorted(ticks), [power_of_ten(t) for t in sorted(ticks)]


def power_of_ten(value: float) -> str:
    """A signed power of ten as LaTeX."""
    if value == 0:
        return "0"
    sign = "−" if value < 0 else "+"
    return rf"${sign}10^{{{round(math.log10(abs(value)))}}}$".replace("−", "-")


def spacing(figure: Figure, **pads: float) -> None:
    """Pads of a constrained layout [in]."""
    engine: Any = figure.get_layout_engine()
    engine.set(**pads)


def key(
    axes: Axes, handles: Sequence[Any], title: str = "", reach: float = 1.3, **options: Any
) -> None:
    """A legend above the axes, where it hides no data, and a title above it.

    Parameters
    ----------
    axes
        Axes with their limits set.
    handles
        Entries; without one there is no legend.
    title
        Title.
    reach
        Widest row over the width of the axes.
    **options
        As for `Axes.legend`.
    """
    pad = 3.0
    if handles:
        # a panel of the package's figures has margins; that of a user has neighbours
        beyond = reach if isinstance(axes.get_figure(root=True), StyledFigure) else 0.9
        room = min(beyond * axes.get_window_extent().width * points(axes), _above(axes))
        swatch = 2.7 * small()
        labels = [
            broken(str(h.get_label()), lambda line: wide(line) + swatch <= room) for h in handles
        ]
        for handle, label in zip(handles, labels, strict=True):
            handle.set_label(label)
        widest = max(wide(line) for label in labels for line in label.split("\n")) + swatch
        gap = 1.2 * small()
        columns = min(len(handles), max(1, int((room + gap) / (widest + gap))))
        legend = axes.legend(
            handles=handles,
            loc="lower center",
            bbox_to_anchor=(0.5, 1.0),
            ncols=columns,
            frameon=False,
            borderpad=0.2,
            borderaxespad=0.15,
            handlelength=2.2,
            handletextpad=0.5,
            columnspacing=1.2,
            labelspacing=0.3,
            **options,
        )
        pad += float(legend.get_window_extent().height) * points(axes)
    if title:
        larger = matplotlib.rcParams["axes.titlesize"] / small()
        lines = broken(title, lambda line: larger * wide(line) <= _above(axes), " ")
        axes.set_title(lines, pad=pad)


def _above(axes: Axes) -> float:
    """Width of a line that is centred above a panel [pt]; the axes of a user have neighbours."""
    figure: Any = axes.get_figure(root=True)
    box, whole = axes.get_window_extent(), figure.bbox
    middle = (box.x0 + box.x1) / 2
    ours = isinstance(figure, StyledFigure)
    width = 2 * min(middle - whole.x0, whole.x1 - middle) if ours else box.width
    return float(width) * points(axes) - 8


def halo(width: float) -> list[Any]:
    """A white edge that keeps a line or a word readable on colours and other lines."""
    return [withStroke(linewidth=width, foreground="white")]


def write(axes: Axes, x: float, y: float, word: str, *, edge: float = 0.0, **look: Any) -> Any:
    """Write a small word, centred on its place, perhaps with a white edge [pt]."""
    usual: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": small()}
    return axes.text(x, y, word, path_effects=halo(edge) if edge else None, **usual | look)


def entry(label: str, **look: Any) -> Line2D:
    """An entry of a legend: a line or a mark."""
    return Line2D([], [], label=label, **look)


def points(axes: Axes) -> float:
    """Size of a pixel [pt]."""
    return float(72 / axes.get_figure(root=True).dpi)  # type: ignore[union-attr]


def wide(text: str) -> float:
    """Width of a line of small text [pt]."""
    font = FontProperties(size=small())
    return float(text_to_path.get_text_width_height_descent(text, font, is_math_text(text))[0])


def note(axes: Axes, text: str) -> None:
    """Write small lines at the foot of the figure, or under a user's axes.

    Parameters
    ----------
    axes
        The lowest axes.
    text
        What is fixed in the figure; nothing is written when empty.
    """
    if not text:
        return
    figure: Any = axes.get_figure(root=True)
    ours, inch = isinstance(figure, StyledFigure), points(axes)
    # the axes of a user may have neighbours
    room = (figure.bbox.width if ours else axes.get_window_extent().width) * inch - 8
    lines = broken(text, lambda line: wide(line) <= room)
    look: dict[str, Any] = {"ha": "center", "fontsize": small()}
    if not ours:
        axes.annotate(
            lines,
            (0.5, 0.0),
            (0, -2),
            xycoords=axes.xaxis.label,
            va="top",
            textcoords="offset points",
            annotation_clip=False,
            **look,
        )
        return
    tall = figure.bbox.height * inch
    written = figure.text(0.5, 3 / tall, lines, va="bottom", **look)
    high = written.get_window_extent().height * inch  # roots are higher than a line
    foot = (max(1.3 * small() * (lines.count("\n") + 1), high + 2) + 3) / tall
    figure.get_layout_engine().set(rect=(0.0, foot, 1.0, 1.0 - foot))


def broken(text: str, fits: Callable[[str], bool], between: str = ", ") -> str:
    r"""Lines that fit; they end after a comma, never between a number and its unit.

    Parameters
    ----------
    text
        A line, or several.
    fits
        Whether a line does.
    between
        What stands between two parts that may be on two lines.

    Examples
    --------
    >>> broken("a = 1 m, b = 2 m, c = 3 m", lambda line: len(line) < 18)
    'a = 1 m, b = 2 m,\nc = 3 m'
    >>> broken("a torus\nas a map", lambda line: "\n" not in line and len(line) < 9, " ")
    'a torus\nas a map'
    """
    whole: list[str] = []
    for line in text.split("\n"):
        lines: list[str] = []
        for part in line.split(between):
            if lines and fits(f"{lines[-1]}{between}{part}"):
                lines[-1] += f"{between}{part}"
            else:
                lines.append(part)
        whole.append(f"{between.rstrip()}\n".join(lines))
    return "\n".join(whole)


def fixed(
    values: Mapping[str, Any],
    quantities: Mapping[str, Quantity],
    units: Mapping[str, str],
    *,
    law: str = "",
    dimensionless: bool = False,
) -> str:
    """The numbers that are the same all over a figure, for its `note`.

    Parameters
    ----------
    values
        Numbers by name.
    quantities
        Quantities of a disk by name; the quantities of a user's system have no symbol.
    units
        Units of a user's quantities by name.
    law
        Contact law.
    dimensionless
        Whether mass, radius (or a body's length) and gravity are 1 by choice of units.

    Examples
    --------
    >>> fixed({"k": 0.25}, {}, {}, law="viscous")
    'viscous contact, k = 0.25'
    """
    parts = [f"{law} contact"] if law else []
    for name, value in values.items():
        quantity = quantities.get(name)
        if dimensionless and name in ("mass", "radius", "length", "gravity"):
            continue
        symbol = (quantity.typeset if quantity else "") or plain_text(name)
        unit = units.get(name, "1")
        if quantity:
            unit = quantity.kind.label(dimensionless=dimensionless)
        shown_unit = "" if unit in ("1", "") else f" {in_latex(unit)}".replace(" $1/", "$/")
        force = f" ({formula_in_latex(quantity.formula)})" if quantity and quantity.formula else ""
        parts.append(f"{symbol} = {float(value):.5g}{shown_unit}{force}")
    return ", ".join(parts)
