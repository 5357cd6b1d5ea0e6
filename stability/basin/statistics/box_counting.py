"""Box dimension of a border from its refinement, and the cells where uncertainty hardly falls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...base.checks import whole_number
from ...base.errors import ParameterError
from ...base.types import Floats
from ..borders import Borders
from ..labels import Ints
from .fractions import LEVEL

FEWEST = 16
"""Unlike pairs of the first level that counts, unless the caller names a level."""
LEVELS = 4
"""Fewest levels that make a dimension."""
SPAN = 6
"""Halvings from a block to the finest cells, of the local exponent."""
HALVINGS = 3
"""Halvings over which the local exponent is taken."""
BOUND = 0.9
"""Local exponent below which a block is sensitive."""


@dataclass(frozen=True)
class BoxDimension:
    """Slope of ln N against -ln w, for N unlike pairs of neighbours at distance w."""

    dimension: float
    """Box dimension D of the border."""
    interval: tuple[float, float]
    """Confidence interval of D, from the scatter of the counts about the line."""
    level: float
    """Its level."""
    levels: tuple[int, int]
    """First and last level of refinement that count."""
    scatter: float
    """Deviation of ln N from the line beyond that of counting, such as a log-periodic one."""

    @property
    def exponent(self) -> float:
        """Uncertainty exponent α = 2 - D."""
        return 2 - self.dimension


def box_dimension(found: Borders) -> BoxDimension:
    """Box dimension of a border from the pairs of unlike neighbours of its levels.

    A share f(w) ~ w^α of all neighbours at distance w is unlike, so their number falls as w^-D.
    Cells are no better: a steep rough curve passes at least one cell of each column, and this
    smooth part hides D to fine widths.  Pairs along x and along y are fitted separately, and the
    larger dimension counts.  ln N has the variance τ² + 1/N about the line, with τ² from the counts
    (moments, as in a random-effects regression).  The interval has Student's quantile.

    Parameters
    ----------
    found
        Borders after at least three halvings.

    Returns
    -------
    BoxDimension
        From the first level with 16 pairs.

    Raises
    ------
    ParameterError
        If fewer than four levels count.

    Source: McDonald, Grebogi, Ott & Yorke, Physica D 17 (1985) 125, section 2; for τ² Knapp &
    Hartung, Statist. Med. 22 (2003) 2693.

    Examples
    --------
    >>> from stability.basin.borders import borders
    >>> def inside(points):
    ...     return np.hypot(points[:, 0], points[:, 1]) < 0.8
    >>> dimension = box_dimension(borders(inside, ("x", -1, 1, 9), ("y", -1, 1, 9), levels=9))
    >>> bool(dimension.interval[0] < 1 < dimension.interval[1]), round(dimension.dimension, 1)
    (True, 1.0)
    """
    ways = [_dimension(counts) for counts in found.crossings.T]
    fits = [fit for fit in ways if fit is not None]
    if not fits:
        raise ParameterError(
            f"fewer than {LEVELS} of {found.levels + 1} levels have {FEWEST} unlike pairs along "
            "one axis; refine further."
        )
    return max(fits, key=lambda fit: fit.dimension)


def _dimension(pairs: Ints) -> BoxDimension | None:
    """The dimension by the pairs along one axis; None where these are too few."""
    from scipy.stats import t as student

    enough = pairs >= FEWEST
    start = int(np.argmax(enough)) if enough.any() else len(pairs)
    counts = pairs[start:].astype(float)
    if len(counts) < LEVELS or (counts == 0).any():
        return None
    design = np.stack([np.ones(len(counts)), np.arange(len(counts)) * np.log(2)], axis=1)
    values = np.log(counts)
    excess = _excess(design, values, counts)
    weight = 1 / (excess + 1 / counts)
    slope, residual, inverse = _line(design, values, weight)
    freedom = len(counts) - 2
    inflation = max(1.0, float(weight @ residual**2) / freedom)
    half = float(student.ppf(0.5 + LEVEL / 2, freedom) * np.sqrt(inverse[1, 1] * inflation))
    ends = slope - half, slope + half
    return BoxDimension(slope, ends, LEVEL, (start, len(pairs) - 1), float(np.sqrt(excess)))


def _line(design: Floats, values: Floats, weight: Floats) -> tuple[float, Floats, Floats]:
    """Slope, residuals and inverse information of a weighted line."""
    inverse = np.asarray(np.linalg.inv(design.T @ (weight[:, None] * design)), dtype=float)
    both = inverse @ design.T @ (weight * values)
    return float(both[1]), values - design @ both, inverse


def _excess(design: Floats, values: Floats, counts: Floats) -> float:
    """Variance about the line beyond 1/N, by moments."""
    _, residual, inverse = _line(design, values, counts)
    misfit = float(counts @ residual**2)
    trace = counts.sum() - np.trace(inverse @ design.T @ (counts[:, None] ** 2 * design))
    return max(0.0, (misfit - (len(counts) - 2)) / float(trace))


@dataclass(frozen=True, eq=False)
class Sensitive:
    """Finest mixed cells, and which of them lie where uncertainty hardly falls."""

    cells: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
    """Whether each of the borders' `cells` is sensitive, shape (m,)."""
    exponent: Floats
    """Local uncertainty exponent at each cell, shape (m,)."""
    bound: float
    """Exponent below which a cell is sensitive."""
    span: int
    """Halvings from a block to the finest cells."""
    blocks: Ints
    """Blocks that hold mixed cells: index along x and y, in blocks, shape (n, 2)."""
    block_exponent: Floats
    """Local uncertainty exponent of each block, shape (n,)."""
    strips: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
    """Whether a block is below the bound through a strip of unfinished launches alone, (n,)."""
    note: str
    """The definition, in a sentence."""

    @property
    def share(self) -> float:
        """Share of the mixed cells that are sensitive; 0 where there is no border."""
        return float(self.cells.mean()) if len(self.cells) else 0.0


def sensitive(
    found: Borders,
    *,
    span: int = SPAN,
    unfinished: Sequence[int] = (),
) -> Sensitive:
    """The parts of a border at which a better known start hardly makes the outcome more certain.

    The map is cut into blocks of 2^`span` finest cells along each axis.  A block has N mixed cells
    of the finest level and M of the level that is h = `HALVINGS` coarser.  Its local exponent is
    2 - log2(N / (M + 1)) / h.  A block is sensitive where this is below `BOUND`.  One arc of a
    monotonous curve passes fewer than 2^h (M + 1) cells and has an exponent above 1, so that a
    smooth border is marked only where several arcs are closer than the width can separate.

    Parameters
    ----------
    found
        Borders.
    span
        Halvings from a block to the finest cells.
    unfinished
        Labels of launches whose end is not known.  Where the horizon ends, a narrow strip of these
        lies between two ends.  Its two sides look like one border at first, so that the number of
        mixed cells doubles once.  Such a block is no longer sensitive, but one of `strips`.

    Returns
    -------
    Sensitive

    Raises
    ------
    ParameterError
        If the borders have fewer levels than `span`, or a number is not accepted.

    Source: final state sensitivity, α < 1: Grebogi, McDonald, Ott & Yorke, Phys. Lett. A 99 (1983)
    415, here between the last widths of a refinement.

    Examples
    --------
    >>> from stability.basin.borders import borders
    >>> def inside(points):
    ...     return np.hypot(points[:, 0], points[:, 1]) < 0.8
    >>> sensitive(borders(inside, ("x", -1, 1, 9), ("y", -1, 1, 9), levels=7)).share
    0.0
    """
    span = whole_number("span", span, least=HALVINGS)
    if span > found.levels:
        raise ParameterError(
            f"the borders have {found.levels} levels; a span of {span} needs as many."
        )
    blocks, block, local = _exponents(found.cells, span)
    strips = np.zeros(len(blocks), dtype=bool)
    if len(unfinished) and (local < BOUND).any():
        strips = (local < BOUND) & _smooth_without(found, unfinished, blocks, span)
    exponents = np.where(strips, np.inf, local)[block]
    note = (
        f"Sensitive: in blocks of 2^{span} cells, the share of uncertain launches falls with an "
        f"exponent below {BOUND:g} over {HALVINGS} halvings."
    )
    if strips.any():
        note += (
            "  Open: the same, but through a strip of launches whose end is not known; counted "
            "with one of the ends next to it, they leave a smooth border."
        )
    return Sensitive(exponents < BOUND, local[block], BOUND, span, blocks, local, strips, note)


def _smooth_without(
    borders: Borders, unfinished: Sequence[int], blocks: Ints, span: int
) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Blocks whose border is smooth once unfinished launches count with another end nearby."""
    labels = _corners(borders)
    open_ = np.isin(labels, unfinished)
    out = np.zeros(len(blocks), dtype=bool)
    for label in np.unique(labels[~open_]):
        merged = np.where(open_, label, labels)
        left = borders.cells[(merged != merged[:, :1]).any(axis=1)]
        if len(left):
            held, _, local = _exponents(left, span)
            smooth = {tuple(b) for b in held[local >= BOUND].tolist()}
            out |= np.array([tuple(b) in smooth for b in blocks.tolist()], dtype=bool)
    return out


def _corners(borders: Borders) -> Ints:
    """Labels of the four corners of each finest mixed cell, shape (m, 4)."""
    row = int(borders.index[:, 1].max()) + 1
    place = borders.index[:, 0].astype(np.int64) * row + borders.index[:, 1]
    order = np.argsort(place)
    step = 2 ** (borders.lattice_levels - borders.levels)
    ends = [(borders.cells + d) * step for d in ((0, 0), (1, 0), (0, 1), (1, 1))]
    asked = np.stack([e[:, 0] * row + e[:, 1] for e in ends], axis=1)
    return np.asarray(borders.labels[order[np.searchsorted(place[order], asked)]])


def _exponents(cells: Ints, span: int) -> tuple[Ints, Ints, Floats]:
    """Blocks that hold mixed cells, the block of each cell, and the exponent of each block."""
    fine, wide = (_in_blocks(cells, n, span) for n in (0, HALVINGS))
    local: Floats = 2 - np.log2(fine / (wide + 1.0)) / HALVINGS
    blocks, block = np.unique(cells >> span, axis=0, return_inverse=True)
    return blocks, np.asarray(block.reshape(-1)), local


def _in_blocks(cells: Ints, coarser: int, span: int) -> Ints:
    """Mixed cells of a coarser level in each block that has one, in order of the blocks."""
    blocks = np.unique(cells >> coarser, axis=0) >> (span - coarser)
    return np.asarray(np.unique(blocks, axis=0, return_counts=True)[1])
