"""Maps in Zarr folders: their arrays, their question, and the work of a chunk."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...algebra.eigensolver import name_of
from ...base.axis import Axis
from ...base.verdict import CODES, Verdict
from ...jobs.chunks import Arrays, Block, Layout, Variable
from ...jobs.zarr_store import ZarrStore
from ...spectra.presentation.labels import axis_attributes
from ...spectra.problem import Problem
from ..cells import Cells
from ..dataset import cell_attributes, provenance
from .verdicts import METHOD, Judge, band, flags

RATES = {"abscissa": "abscissa", "abscissa_error": "error", "frequency": "frequency"}
"""Arrays of growth rates: the name in a dataset, and that in a chunk of `Cells`."""
GROWN = 25
"""Bytes of a cell with its growth rates, not compressed; one of a verdict alone."""


def verdict_store(
    folder: Path, problem: Problem, axes: tuple[Axis, Axis], layout: Layout, *, overwrite: bool
) -> ZarrStore:
    """The store of a map of verdicts.

    Parameters
    ----------
    folder, layout, overwrite
        As for `ZarrStore`.
    problem, axes
        Family with values in the user's units; x and y.
    """
    arrays = (Variable("verdict", "int8", -1, flags()),)
    return _store(folder, problem, axes, layout, arrays, METHOD, {}, overwrite)


def growth_store(folder: Path, cells: Cells, layout: Layout, *, overwrite: bool) -> ZarrStore:
    """The store of a map of verdicts and growth rates.

    Parameters
    ----------
    folder, layout, overwrite
        As for `ZarrStore`.
    cells
        The cells of the map.
    """
    attributes = cell_attributes(cells.problem, missing=not cells.exact)
    arrays = (
        Variable("verdict", "int8", -1, attributes["verdict"]),
        *(Variable(name, "float64", np.nan, attributes[name]) for name in RATES),
    )
    question = {"growth rates": True, "solver of eigenvalues": name_of(cells.solver)}
    return _store(
        folder, cells.problem, cells.axes, layout, arrays, cells.method, question, overwrite
    )


def _store(
    folder: Path,
    problem: Problem,
    axes: tuple[Axis, Axis],
    layout: Layout,
    arrays: tuple[Variable, ...],
    method: str,
    more: Mapping[str, Any],
    overwrite: bool,
) -> ZarrStore:
    """The store of a map; equal maps have equal files, so it holds no date."""
    coords = {
        name: (grid.name, grid.values, axis_attributes(problem, grid.name))
        for grid in axes
        for name in filter(None, (grid.name, grid.alias))
    }
    attrs = {n: v for n, v in provenance(problem, axes, method).items() if n != "created"}
    graph = hashlib.sha256(str(problem.family.system.rhs).encode()).hexdigest()
    question = {"equations": graph, "anchor": repr(problem.family.anchor), **more}
    return ZarrStore(folder, layout, arrays, coords, attrs, question, overwrite=overwrite)


@dataclass(frozen=True)
class VerdictChunk:
    """Work of a chunk of verdicts."""

    judge: Callable[[], Judge]
    """Gives this worker's judge."""
    axes: tuple[Axis, Axis]
    """x and y."""
    layout: Layout
    """The grid of chunks."""

    def __call__(self, block: Block, part: slice) -> Arrays:
        """Arrays of a part of the chunk's cells."""
        rows, columns = self.layout.slices(block)
        codes, _ = band(self.judge, self.axes[0].values[columns], self.axes[1].values[rows])
        return {"verdict": codes.astype(np.int8, copy=False).ravel()[part]}


@dataclass(frozen=True)
class GrowthChunk:
    """Work of a chunk of verdicts and growth rates."""

    cells: Callable[[], Cells]
    """Gives this worker's cells."""
    layout: Layout
    """The grid of chunks."""

    def __call__(self, block: Block, part: slice) -> Arrays:
        """Arrays of a part of the chunk's cells."""
        cells = self.cells()
        rows, columns = self.layout.slices(block)
        found = cells.part(cells.axes[0].values[columns], cells.axes[1].values[rows])
        rates = {name: found[own][part] for name, own in RATES.items()}
        return {"verdict": found["codes"][part], **rates}


def no_verdicts(count: int) -> Arrays:
    """Verdicts of cells that ended their worker."""
    return {"verdict": np.full(count, CODES[Verdict.UNDECIDED], dtype=np.int8)}


def no_rates(count: int) -> Arrays:
    """The same with growth rates: numbers are missing, and the bound is infinite."""
    missing = np.full(count, np.nan)
    bound = np.full(count, np.inf)
    return {
        **no_verdicts(count),
        "abscissa": missing,
        "abscissa_error": bound,
        "frequency": missing,
    }
