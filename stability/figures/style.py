"""Style of figures: sizes, spacing, files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from .canvas import save_figure

COLUMN = 3.39
"""Width of a journal column [in]."""


def spacing(figure: Figure, **pads: float) -> None:
    """Pads of a constrained layout [in]."""
    engine: Any = figure.get_layout_engine()
    engine.set(**pads)


def power_of_ten(value: float) -> str:
    """A signed power of ten as LaTeX."""
    if value == 0:
        return "0"
    sign = "−" if value < 0 else "+"
    return rf"${sign}10^{{{round(np.log10(abs(value)))}}}$".replace("−", "-")


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
    from ..storage.files import whole

    paths = [stem.parent / (stem.name + suffix) for suffix in (".png", ".pdf")]
    for path in paths:
        with whole(path, overwrite=True) as beside:
            # no creation date, so that the same map gives the same file
            meta = {"CreationDate": None} if path.suffix == ".pdf" else None
            save_figure(figure, beside, metadata=meta)
    return paths
