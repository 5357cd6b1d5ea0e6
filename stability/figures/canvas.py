"""Matplotlib without a screen or the settings of the user's machine; sizes, spacing, files.

Import this module before Matplotlib.  Otherwise an unknown backend, in the environment or in a
`matplotlibrc`, ends in a traceback, and settings such as `text.usetex` change every figure.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.looks import LIGHT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..base.types import Overwrite

_asked = os.environ.pop("MPLBACKEND", None)
_log = logging.getLogger("matplotlib")
_level = _log.level
_log.setLevel(logging.ERROR)  # a missing cache or font does not concern the user
try:
    import matplotlib
finally:
    _log.setLevel(_level)
    if _asked is not None:
        os.environ["MPLBACKEND"] = _asked
if _asked:  # figures of the user keep their backend, if its name is known
    with suppress(ValueError):
        matplotlib.rcParams["backend"] = _asked

BASE = 7.5
"""Size of text [pt]; the smallest text of a figure is 1 pt smaller."""
DOTS = 300
"""Dots an inch of files."""
LEAST = 7.0
"""Least size of text that is accepted [pt], so that no text is below 6 pt."""


def styled(fontsize: float = BASE) -> dict[Any, Any]:
    """Settings of the package's figures for a size of text.

    Parameters
    ----------
    fontsize
        Size of text [pt].
    """
    return {
        "font.size": fontsize,
        "axes.labelsize": fontsize + 0.5,
        "axes.titlesize": fontsize + 0.5,
        "xtick.labelsize": fontsize - 0.5,
        "ytick.labelsize": fontsize - 0.5,
        "legend.fontsize": fontsize - 1,
        "axes.linewidth": 0.6,
        "xtick.major.width": 0.6,
        "ytick.major.width": 0.6,
        "hatch.linewidth": 0.35,
        "hatch.color": LIGHT.hatch,
        "savefig.dpi": DOTS,
        "svg.hashsalt": "stability",
        "pdf.fonttype": 42,
        "ps.fonttype": 42,
        "mathtext.fontset": "dejavusans",
        "lines.linewidth": 1.3,
    }


STYLE = styled()
"""Settings of the package's figures."""
FORMATS = (".png", ".pdf")
"""Endings of the files of a figure."""
UNDATED = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
"""Metadata of files without a date, so that the same figure gives the same file."""
RENDERERS = {"png": "agg", "pdf": "pdf", "svg": "svg"}
"""Backend of Matplotlib by kind of file."""
COLUMN = 3.39
"""Width of a journal column [in]."""
OF_THE_SESSION = (
    "backend",
    "interactive",
    "toolbar",
    "webagg.",
    "tk.",
    "keymap.",
    "date.epoch",
    "timezone",
    "docstring.",
    "figure.max_open_warning",
    "figure.raise_window",
    "savefig.directory",
    "animation.",
)
"""Settings that are not style, by the start of their names."""


@cache
def _defaults() -> dict[Any, Any]:
    default = matplotlib.rcParamsDefault
    return {n: default[n] for n in default if not n.startswith(OF_THE_SESSION)}


@contextmanager
def figure_style(style: Mapping[str, Any]) -> Iterator[None]:
    """Draw with Matplotlib's defaults and these changes, under any settings of the user.

    Parameters
    ----------
    style
        Settings by name.
    """
    with matplotlib.rc_context(_defaults() | dict(style)):
        yield


@contextmanager
def unchanged(figure: Figure) -> Iterator[None]:
    """Do what changes a figure for Matplotlib and not for the user, such as drawing it."""
    before = getattr(figure, "changed", False)
    try:
        yield
    finally:
        figure.changed = before  # type: ignore[attr-defined]


@contextmanager
def laid_out(figure: Figure) -> Iterator[None]:
    """Give the panels their places once, at `DOTS`, and hold them for every file of the figure.

    Matplotlib would measure all text again for each file, and draw each of them twice.
    """
    engine, dots = figure.get_layout_engine(), figure.dpi
    try:
        with unchanged(figure):
            figure.dpi = DOTS
            if engine is not None:
                engine.execute(figure)
                figure.set_layout_engine("none")
        yield
    finally:
        with unchanged(figure):
            if engine is not None:
                figure.set_layout_engine(engine)
            figure.dpi = dots


def save_figure(
    figure: Figure,
    path: str | os.PathLike[str],
    *,
    overwrite: Overwrite = True,
    **options: Any,
) -> None:
    """Write a figure at 300 dots an inch, whole or not at all, with the record of its origin.

    Parameters
    ----------
    figure
        The figure.
    path
        File to write; its suffix names the format: PNG, PDF or SVG.
    overwrite
        Whether an existing file may be replaced; "same": if the same call wrote it.
    **options
        As for `FigureCanvasAgg.print_png`, `print_pdf` and `print_svg` of Matplotlib.
    """
    with figure_style(getattr(figure, "settings", STYLE)), laid_out(figure):
        _write(figure, Path(path), overwrite, **options)


def _write(figure: Figure, name: Path, overwrite: Overwrite, **options: Any) -> None:
    """Draw the figure as it stands, once, into a file."""
    content, kind, canvas = BytesIO(), name.suffix[1:].lower(), figure.canvas
    backend = import_module(f"matplotlib.backends.backend_{RENDERERS[kind]}")
    undated = {"metadata": UNDATED.get(f".{kind}")}
    with unchanged(figure):
        try:
            writer = canvas if hasattr(canvas, f"print_{kind}") else backend.FigureCanvas(figure)
            # in memory: on a full disk the PDF writer of Matplotlib raises a different error
            getattr(writer, f"print_{kind}")(content, **undated | options)
        finally:
            figure.set_canvas(canvas)
    keep(figure, name, content.getvalue(), overwrite, options)


def keep(
    figure: Figure, path: Path, content: bytes, overwrite: Overwrite, options: Mapping[str, Any]
) -> None:
    """Write the bytes of a figure with the record of the call that drew it.

    What was changed since that call is compared by the bytes of the file.
    """
    from ..storage.files import write_file
    from ..storage.origin import LATER, digest_of, with_arguments

    later = {LATER: digest_of(content)} if getattr(figure, "changed", False) else {}
    origin = with_arguments(getattr(figure, "origin", None), {**options, **later})
    write_file(path, content, overwrite=overwrite, origin=origin)


def save(figure: Figure, stem: Path, formats: Sequence[str] = FORMATS) -> list[Path]:
    """Write a figure as PNG and PDF, or in other formats.

    Parameters
    ----------
    figure
        The figure.
    stem
        Path without suffix; files there are replaced.
    formats
        Endings of the files.

    Returns
    -------
    list of Path
        The files.
    """
    paths = [stem.parent / (stem.name + suffix) for suffix in formats]
    with figure_style(getattr(figure, "settings", STYLE)), laid_out(figure):
        for path in paths:
            _write(figure, path, overwrite=True)
    return paths
