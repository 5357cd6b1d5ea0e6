"""Parameter grids: abscissa and verdict over two axes, with the boundaries between verdicts."""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import Executor
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ..base.axis import AxisLike
from ..base.checks import flag, whole_number
from ..base.errors import ParameterError
from ..bodies.contact_laws import Contact
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..boundary.curves import trace
from ..spectra.axes import swept
from ..storage.pieces import Checkpoint
from ..systems.family import Family
from ..systems.sources.numeric import NumericSystem
from .boxes import MOST_LEVELS, prove_boxes
from .cells import Cells
from .sheets import sheet_box, sheet_counts
from .unstable import unstable_variable

if TYPE_CHECKING:
    import xarray

from ..base.types import Progress
from ..jobs.dask import check_pool, pool_of

MOST_CELLS = 100_000_000
"""Largest map in memory."""


def stability_map(
    family: str | Family,
    *,
    x: AxisLike,
    y: AxisLike,
    disk: Disk | None = None,
    body: Body | Disk | None = None,
    contact: Contact | type[Contact] | str | None = None,
    at: ArrayLike | None = None,
    certify: bool = False,
    levels: int | None = None,
    boundaries: bool = True,
    points: bool = False,
    box: Mapping[str, ArrayLike] | None = None,
    modes: bool = False,
    unstable: bool = False,
    workers: int | None = None,
    executor: Executor | str | None = None,
    progress: Progress | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    **parameters: ArrayLike,
) -> xarray.Dataset:
    """Abscissa, verdict and the boundaries between verdicts over two parameters.

    Maps of Python functions are by floats, not proved, as their attribute `evidence` says.

    Parameters
    ----------
    family
        Name of a disk's family, or a `Family`.
    x, y
        Axes as (name, low, high, n) or (name, low, high, n, "log"): any two of `at`
        (or its own name: `omega3`, `phi_dot`, `theta`), `k`, `mu`,
        `mass`, `radius`, `gravity`; `lean` for tumbling, `theta`, `phi_dot` for circling and
        precession; for a `Family`, its own names.
    disk, body, contact, at
        Fixed values, as for `spectrum`.  An axis replaces a value in disk or contact; any other
        quantity that is an axis must not be given as a number too.  Where `mu` is an axis, contact
        may be left out (viscous) or be a law's class or name.
    certify
        Whether to prove whole boxes of the map too, to enclose the boundary in a strip of narrow
        boxes, and to decide in balls every cell that double precision leaves open.
    levels
        Number of halvings of the map for the boxes; as fine as the cells, but at most 12, when left
        out.
    boundaries
        Whether to find the boundary curves.
    points
        Whether to find the points of codimension two, as `codimension_two` does.
    box
        For a family of your own that is solved for: (low, high) of each of its unknowns.  Then
        `equilibria` and `stable_equilibria` count, in each cell, the equilibria in the box on all
        sheets, with the family's held states.
    modes
        Whether to keep all eigenvalues (complex, dimension `mode`).
    unstable
        Whether to count the unstable eigenvalues in each cell.
    workers
        Number of workers; the number of processors when left out.
    executor
        `threads`, `processes`, `dask` (a scheduler and workers on this machine), the address of a
        running scheduler, or any `concurrent.futures.Executor`; threads when left out.
    progress
        Called with (cells done, cells in all) now and then.
    checkpoint
        Folder for finished cells, so that the same call continues where an interrupted one stopped.
        The folder may be removed afterwards.
    **parameters
        For a `Family`: its fixed parameters by name; those with the name of an argument, such as
        `at` or `x`, in a mapping called `parameters`.

    Returns
    -------
    xarray.Dataset
        Dimensions and coordinates named like the axes, y first; the disk's
        axis omega3, phi_dot or theta has the dimension `at`, and its name is a second coordinate.
        Variables: `abscissa`,
        `abscissa_error` (a bound), `frequency` (of the eigenvalue with the largest real part),
        `verdict` (CF flags).  A cell whose parameters have no member has the flag `no_member`, and
        its numbers are missing (NaN in memory, which xarray leaves out of its sums and extremes;
        `_FillValue` in a file).  Along `boundary_point`: `boundary_X` for each axis X,
        `boundary_error`, `boundary_axis` (along which the error is meant), `boundary_kind`,
        `boundary_frequency`, `boundary_curve` (which polyline); if certified, along `box`: `box_X`
        (low and high end) and `box_verdict` (proved on all of the box, 0 in the strip); with
        points, along `point`: `point_X` and `point_X_error` (a proved bound), `point_kind`,
        `point_frequency` (of each pair) and `point_others`, and attributes `points_…` that say how
        these were sought, whether they are all, and what stays open; with box, `equilibria` and
        `stable_equilibria`, and with unstable, `unstable` (proved numbers, -1 where not proved, and
        a comment that says in how many cells).
        Attributes hold units, versions, parameters, method and tolerances.

    Raises
    ------
    StabilityError
        One sentence that says what is wrong and what is accepted.

    Source: every number has an independent oracle in tests/maps/test_maps.py.

    Examples
    --------
    >>> import stability as st
    >>> m = st.stability_map("spinning", x=("at", 1, 4, 7), y=("mu", 0.1, 2, 5))
    >>> m.abscissa.dims, m.abscissa.shape
    (('mu', 'at'), (5, 7))

    >>> import casadi as ca
    >>> x, a, b = (ca.SX.sym(n) for n in "xab")
    >>> cusp = st.System("cusp", x, ca.vertcat(a, b), a + b * x - x**3, states=("x",),
    ...                  parameters=("a", "b"))
    >>> upper = cusp.steady("b", guess={"x": 1, "b": 1}, a=0.1)
    >>> m = st.stability_map(upper, x=("a", -1, 1, 4), y=("b", 0, 1, 2), box={"x": (-3, 3)})
    >>> m.equilibria.values.tolist(), m.stable_equilibria.values.tolist()
    ([[1, 1, 1, 1], [1, 3, 3, 1]], [[1, 1, 1, 1], [1, 2, 2, 1]])
    """
    certify, boundaries = flag("certify", certify), flag("boundaries", boundaries)
    modes, points = flag("modes", modes), flag("points", points)
    unstable = flag("unstable", unstable)
    if levels is not None and not certify:
        raise ParameterError("levels belongs to certify=True; leave it out or certify.")
    if levels is not None:
        levels = whole_number("levels", levels, 0, MOST_LEVELS)
    check_pool(executor, workers, progress)
    problem, (across, up) = swept(
        family, {"x": x, "y": y}, disk, body, contact, at, parameters, linear=True
    )
    axes = across, up
    if certify and isinstance(problem.family.system, NumericSystem):
        raise ParameterError(problem.family.system.no_graph)
    box = None if box is None else sheet_box(problem.family, box)
    if (total := axes[0].count * axes[1].count) > MOST_CELLS:
        raise ParameterError(
            f"the map has {total:.3g} cells, at most {MOST_CELLS:.0e} are kept in memory; take "
            "fewer points, or stream_map (`--out map.zarr`), which writes a folder."
        )
    marked = None
    if points:  # first, since a family may be refused
        from ..boundary.two_parameters.points import in_plane

        marked = in_plane(problem, axes)
    cells = Cells(problem, axes, modes)
    parts = Checkpoint(checkpoint, cells.key(), cells.fits) if checkpoint is not None else None
    with pool_of(executor, workers) as (pool, number):
        cells.fill(number or os.cpu_count() or 1, progress, parts, pool)
    from .dataset import assemble

    boxes = None
    if certify:
        finest = (max(g.count for g in axes) - 1).bit_length()
        boxes = prove_boxes(problem, axes, min(finest, 12) if levels is None else levels)
    cells.settle(certify=certify)
    curves = trace(problem, axes, cells.codes, cells.abscissa, progress) if boundaries else None
    counts = {} if box is None else sheet_counts(problem, axes, box)
    if unstable:
        counts |= unstable_variable(cells, certify=certify)
    return assemble(problem, axes, cells, curves, boxes, marked, counts)
