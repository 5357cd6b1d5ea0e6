"""Matplotlib without a screen or the settings of the user's machine; sizes, spacing, files.

Import this module before Matplotlib.  Otherwise an unknown backend, in the environment or in a
`matplotlibrc`, ends in a traceback, and settings such as `text.usetex` change every figure.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
        "font.size": fontsize, "axes.labelsize": fontsize + 0.5, "axes.titlesize": fontsize + 0.5,
        "xtick.labelsize": fontsize - 0.5, "ytick.labelsize": fontsize - 0.5,
        "legend.fontsize": fontsize - 1,
        "axes.linewidth": 0.6, "xtick.major.width": 0.6, "ytick.major.width": 0.6,
        "hatch.linewidth": 0.35, "hatch.color": "#2b1000", "savefig.dpi": 300, "pdf.fonttype": 42,
        "ps.fonttype": 42, "mathtext.fontset": "dejavusans", "lines.linewidth": 1.3,
    }  # fmt: skip


STYLE = styled()
"""Settings of the package's figures."""
FORMATS = (".png", ".pdf")
"""Endings of the files of a figure."""
COLUMN = 3.39
"""Width of a journal column [in]."""
OF_THE_SESSION = (
    "backend", "interactive", "toolbar", "webagg.", "tk.", "keymap.", "date.epoch", "timezone",
    "docstring.", "figure.max_open_warning", "figure.raise_window", "savefig.directory",
    "animation.",
)  # fmt: skip
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


def save_figure(figure: Figure, path: str | os.PathLike[str], **options: Any) -> None:
    """Write a figure at 300 dots an inch.

    Parameters
    ----------
    figure
        The figure.
    path
        File to write; its suffix names the format.
    **options
        As for `savefig`.
    """
    name, content = Path(path), BytesIO()
    # in memory: on a full disk the PDF writer of Matplotlib raises a different error
    with figure_style(getattr(figure, "settings", STYLE)):
        figure.savefig(content, format=name.suffix[1:].lower(), dpi=300, **options)
    name.write_bytes(content.getbuffer())


def save(figure: Figure, stem: Path) -> list[Path]:
    """Write a figure as PNG and PDF.

    Parameters
    ----------
    figure
        The figure.
    stem
        Path without suffix; files there are replaced.

    Returns
    -------
    list of Path
        The two files.
    """
    from ..storage.files import atomic_write

    paths = [stem.parent / (stem.name + suffix) for suffix in FORMATS]
    for path in paths:
        with atomic_write(path, overwrite=True) as draft:
            # no creation date, so that the same map gives the same file
            meta = {"CreationDate": None} if path.suffix == ".pdf" else None
            save_figure(figure, draft, metadata=meta)
    return paths
