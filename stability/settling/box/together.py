"""Settling of many states at once: the proof of `stability.settling.box.alone` by a kernel.

The same box and the same inequality, in balls of doubles.  The basis is the real modal basis of a
member nearby, by LAPACK; launches with the same parameters share the bases of members on a grid.
One whose proof just misses tries the two bases of the single test, each its own.
Any basis is sound: its inverse is enclosed (`stability.settling.box.kernel`).  Where Numba
is missing NumPy runs the same functions, with the same results to the last bit of each bound.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...algebra.kernels import double_balls
from ...algebra.kernels.compiled import compiled
from ...algebra.kernels.double_balls import UP
from ...algebra.kernels.tape import LANES, Tape, recorded
from ...algebra.number_types import Algebra
from ...base.errors import StabilityError
from ...base.types import Floats
from ..surroundings import Surroundings
from . import kernel
from .alone import ROOM, TURNS, WIDEN

KERNELS: tuple[ModuleType, ...] = (double_balls, kernel)
MOST = 60
"""Most states across a family for which the roundings are bounded."""
STEP = 2.0**-12
"""Spacing of the members whose bases launches share."""
APART = 0.05
"""Largest part of the slowest rate by which a shared basis may change a launch's slopes."""
JUST = 4.0
"""Rates by which a proof may miss and is tried again, in the launch's own two bases."""
NEARER, MARGIN, LEAST = 0.6, 0.8, 0.05
"""Part of the distance where the next proof may succeed: without an estimate, over the estimate,
and at least."""
SPARE = 2.0**-46
"""Half-width of the first box along the family, over the size of its centre: above rounding."""


class Balls(NamedTuple):
    """Centres and radii."""

    mid: Floats
    """Centres."""
    rad: Floats
    """Radii, of the same shape."""


@dataclass(frozen=True, eq=False)
class Settled:
    """Which of many launches are proved to converge to one steady motion."""

    proved: NDArray[np.bool_]
    """Whether convergence is proved, shape (launches,)."""
    limit: Floats
    """Parameters y of a member near that steady motion, shape (launches, n); nan if not proved."""
    error: Floats
    """Bound on the distance of the limit from that motion, as `Attraction.error`."""
    rate: Floats
    """Least rate at which the deviation falls, in the norm of the basis."""
    reach: Floats
    """Half the diagonal of the box across the family."""
    nearer: Floats
    """Part of its distance at which a launch that is not proved may be, an estimate in (0, 1)."""


Bases = tuple[NDArray[np.bool_], Floats, Floats, Floats]
"""Whether the members near launches are stable, Z, X, and the slowest rates."""


def nothing(count: int, n: int) -> Settled:
    """Proofs of no launch.

    Parameters
    ----------
    count
        Number of launches.
    n
        Parameters of a member.
    """
    error, rate, reach = (blank := np.full((3 + n, count), np.nan))[:3]
    proved, nearer = np.zeros(count, bool), np.full(count, NEARER)
    return Settled(proved, blank[3:].T, error, rate, reach, nearer)


@dataclass(frozen=True, eq=False)
class Tapes:
    """Surroundings of a family as tapes."""

    box: Tape
    """(y, given, e) → ∂G/∂e and ∂g/∂e by rows, then the guards."""
    rest: Tape | None
    """(y, given, e) → G."""


@lru_cache(maxsize=32)
def tapes(around: Surroundings) -> Tapes:
    """Surroundings of a family as tapes.

    Raises
    ------
    StabilityError
        If its graph has a function without a kernel, or too many states.
    """
    n, count, across = sizes = around.slopes.inputs[:3]
    if across > MOST:
        raise StabilityError(f"{across} states across a family are too many for the kernel.")
    inputs = sum(sizes)

    def split(a: list[Any]) -> list[list[Any]]:
        return [a[:n], a[n : n + count], a[n + count :]]

    def box(a: list[Any], number: Algebra) -> list[Any]:
        rows = around.slopes.dense(number, split(a))
        return [v for row in rows for v in row] + around.positive.run(number, split(a))[0]

    rest = around.remainder
    if rest is None:
        return Tapes(recorded(box, inputs), None)
    return Tapes(
        recorded(box, inputs),
        recorded(lambda a, number: [v for [v] in rest.dense(number, split(a))], inputs),
    )


def boxes(  # noqa: PLR0913
    around: Surroundings,
    y: Balls,
    given: Floats,
    e: Balls,
    found: Settled,
    left: NDArray[np.bool_],
    *,
    plain: bool = False,
) -> None:
    """Write down which launches are proved to converge by a box about each.

    Parameters
    ----------
    around, y, given, e, plain
        As for `stability.settling.proof.settled`.
    found
        Where proofs are written.
    left
        Launches that are tried, shape (launches,).

    Raises
    ------
    StabilityError
        If the family's graph has a function without a kernel, such as exp.
    """
    test = _Test(around, tapes(around), y, given, e, found, plain, np.zeros(len(given), bool))
    with np.errstate(all="ignore"):  # nan is never proved
        some, centre, slow, a = test.centres(left)
        if around.along == 1:  # launches with the same parameters share bases
            test.proofs(some, centre, slow, test.shared_bases(some, centre, a))
            some, centre, slow, a = test.missed(some, centre, slow, a)
        test.proofs(some, centre, slow, _modal(a))
        some, centre, slow, a = test.missed(some, centre, slow, a)
        test.proofs(some, centre, slow, _lyapunov(a))


@dataclass(frozen=True, eq=False)
class _Test:
    """One call of `boxes`; `some` are numbers of launches that may still be proved."""

    around: Surroundings
    made: Tapes
    y: Balls
    given: Floats
    e: Balls
    found: Settled
    plain: bool
    just: NDArray[np.bool_]
    """Which launches are proved, or nearly."""

    def slopes(self, y: Floats, given: Floats) -> Floats:
        """∂G/∂e and ∂g/∂e at members, shape (launches, m + n, m)."""
        m, n = self.around.across, self.around.along
        points = np.concatenate([y, given, np.zeros((len(y), m))], axis=1)
        mid, _ = self.made.box.run(points.T, plain=self.plain)
        found: Floats = mid[: (m + n) * m].T.reshape(-1, m + n, m)
        return found

    def centres(self, left: NDArray[np.bool_]) -> tuple[Any, Floats, Floats, Floats]:
        """Launches, centres y_c = y - ℓᵀe, rows ℓ with ℓᵀA = ∂g/∂e there, and A."""
        m = self.around.across
        whole = np.isfinite(np.hstack([self.y.mid, self.given, self.e.mid])).all(1)
        some = np.flatnonzero(whole & left)
        y, e, given = self.y.mid[some], self.e.mid[some], self.given[some]
        centre, slow, a = y, np.zeros((len(y), self.around.along, m)), np.zeros((len(y), m, m))
        for _ in range(3):
            both = self.slopes(centre, given)
            a, right = both[:, :m], both[:, m:].swapaxes(1, 2)
            slow = _solved(a.swapaxes(1, 2), right).swapaxes(1, 2)
            centre = y - (slow @ e[..., None])[..., 0]
        good = np.isfinite(a).all((1, 2)) & np.isfinite(centre).all(1)
        return some[good], centre[good], slow[good], a[good]

    def shared_bases(self, some: Any, centre: Floats, a: Floats) -> Bases:
        """The bases of members on a grid; a launch that they do not fit has its own."""
        if not len(some):
            return _modal(a)
        # in any company the same: the basis of the next member on the grid
        own = np.column_stack([np.rint(centre[:, 0] / STEP), self.given[some]])
        nodes, rows = np.unique(own, axis=0, return_inverse=True)
        both = self.slopes(nodes[:, :1] * STEP, nodes[:, 1:])
        there, mine = both[:, : self.around.across], rows.ravel()
        stable, z, x, rate = _modal(there)
        stable, z, x, rate = stable[mine], z[mine], x[mine], rate[mine]
        off = z @ (a - there[mine]) @ x
        poor = ~(np.square(off).sum((1, 2)) < np.square(APART * rate))
        stable[poor], z[poor], x[poor], rate[poor] = _modal(a[poor])
        return stable, z, x, rate

    def missed(self, some: Any, *rest: Floats) -> tuple[Any, ...]:
        """Launches that just miss the proof, and their parts of some arrays."""
        again = self.just[some] & ~self.found.proved[some]
        return some[again], *(v[again] for v in rest)

    def proofs(self, some: Any, centre: Floats, slow: Floats, bases: Bases) -> None:
        """Try the proof of launches near a stable member."""
        stable, *rest = bases
        whole = [v[stable] for v in (some, centre, slow, *rest)]
        for low in range(0, len(whole[0]), LANES):
            self.widened(*(v[low : low + LANES] for v in whole))

    def widened(
        self, some: Any, centre: Floats, slow: Floats, z: Floats, x: Floats, rate: Floats
    ) -> None:
        """Widen the boxes of launches until each is proved or given up."""
        loops, made, m = compiled(*KERNELS, plain=self.plain), self.made, self.around.across
        c, ell, z, x = (_lanes(v) for v in (centre, slow, z, x))
        y, ry, e, re = (_lanes(v[some]) for v in (*self.y, *self.e))
        given = _lanes(self.given[some])
        f, kappa, r, eta, rows, turned = loops.start(z, x, ell, y, ry, e[:, None], re[:, None], c)
        rho = np.zeros_like(r)
        if made.rest is not None:
            rho, slowest = self._remainder(loops, given, z, x)
            r = (r + ROOM * rho / slowest) * UP + 2.0**-64
        across, sideways = rows * r * UP, turned * r * UP
        delta = 2 * (eta + sideways) + SPARE * (1 + np.abs(c))
        for turn in range(TURNS):
            mid, rad = np.zeros((2, made.box.inputs, len(some)))
            mid[: len(c)], mid[len(c) : -m], rad[: len(c)], rad[-m:] = c, given, delta, across
            mid, rad = made.box.run(mid, rad, plain=self.plain)
            cut = (len(c) + m) * m
            j, rj = (v[:cut].reshape(-1, m, len(some)) for v in (mid, rad))
            beta, error = loops.turn(z, x, ell, j, rj, f, kappa, r, eta)
            if not turn:  # the rate of a box falls in proportion to its size, about
                share = np.maximum(MARGIN * rate / (rate - beta), LEAST)
                before = np.where(self.just[some], self.found.nearer[some], 0.0)
                self.found.nearer[some] = np.maximum(np.where(beta < 0, share, NEARER), before)
                self.just[some] |= beta > -JUST * rate
            fine = (mid[cut:] > rad[cut:]).all(0) & (beta > 0) & (beta * r > rho * UP)
            needed = (error + sideways) * UP
            done = fine & (needed <= delta).all(0)
            if made.rest is not None:
                error = (np.sqrt((rows * rows).sum(0)) * rho / beta)[None] * UP
            self._keep(some[done], c[:, done], error[:, done], beta[done], across[:, done])
            go = fine & ~done
            if not go.any():
                return
            some, delta = some[go], WIDEN * needed[:, go]
            c, ell, z, x, given, f, kappa, r, eta, across, sideways, rho, rows = (
                np.ascontiguousarray(v[..., go])
                for v in (c, ell, z, x, given, f, kappa, r, eta, across, sideways, rho, rows)
            )

    def _remainder(self, loops: Any, given: Floats, z: Floats, x: Floats) -> tuple[Floats, Floats]:
        """|Z G| at e = 0, and the rate at which deviations fall there, in double precision."""
        m, made = self.around.across, self.made
        points = np.vstack([given, np.zeros((m, given.shape[1]))])
        assert made.rest is not None
        rest, off = (v[:, None] for v in made.rest.run(points, plain=self.plain))
        moved, wide = np.zeros_like(rest), np.zeros_like(rest)
        loops.product(z, rest, off, moved, wide)
        zs, xs = np.moveaxis(z, -1, 0), np.moveaxis(x, -1, 0)
        j = zs @ self.slopes(np.zeros((len(zs), 0)), given.T) @ xs
        highest = np.linalg.eigvalsh((j + j.swapaxes(1, 2)) / 2).max(1)
        return loops.length(moved[:, 0], wide[:, 0]), np.maximum(-highest, 1e-300)

    def _keep(self, some: Any, c: Floats, error: Floats, beta: Floats, across: Floats) -> None:
        found = self.found
        found.proved[some], found.limit[some] = True, c.T
        found.error[some] = error.max(0)
        found.rate[some], found.reach[some] = beta, np.sqrt((across * across).sum(0))


def _lanes(v: Floats) -> Floats:
    """An array with its launches along the last axis."""
    return np.ascontiguousarray(np.moveaxis(v, 0, -1))


def _modal(a: Floats) -> Bases:
    """Whether matrices are stable, their real modal bases Z and X = Z⁻¹, and their slowest rates.

    The columns of X are real and imaginary parts of the eigenvectors.
    """
    stable, values, vectors, rate = _eigen(a)
    x = np.where(values.imag[:, None] < 0, vectors.imag, vectors.real)
    z = _solved(x, np.broadcast_to(np.eye(x.shape[1]), x.shape))
    return stable & np.isfinite(z).all((1, 2)), z, x, rate


def _lyapunov(a: Floats) -> Bases:
    """As `_modal`, by the bases in which the symmetric part of A is diagonal: AᵀP + PA = -1.

    With A = V Λ V⁻¹ entry (i, j) of VᴴPV is that of VᴴV over -(λ̄_i + λ_j).
    """
    stable, values, v, rate = _eigen(a)
    w = _solved(v, np.broadcast_to(np.eye(v.shape[1]), v.shape))
    falls = -(values.conj()[:, :, None] + values[:, None, :])
    p = (w.conj().swapaxes(1, 2) @ (v.conj().swapaxes(1, 2) @ v / falls) @ w).real
    stable &= np.isfinite(p).all((1, 2))
    levels, q = np.linalg.eigh(np.where(stable[:, None, None], p, 0.0))
    stable &= (levels > 0).all(1)
    root = np.sqrt(np.where(stable[:, None], levels, 1.0))[:, None]
    return stable, (q * root).swapaxes(1, 2), q / root, rate


def _eigen(a: Floats) -> tuple[NDArray[np.bool_], Any, Any, Floats]:
    """Whether matrices are stable, eigenvalues, eigenvectors, and slowest rates."""
    whole: Any = np.isfinite(a).all((1, 2))
    values, vectors = np.linalg.eig(np.where(whole[:, None, None], a, 0.0))
    rate = -values.real.max(1, initial=-np.inf)
    return whole & (rate > 0), values, vectors, rate


def _solved(a: Floats, b: Floats) -> Floats:
    """Solutions of many linear systems, nan where the matrix is singular."""
    with np.errstate(all="ignore"):
        regular: Any = np.isfinite(a).all((1, 2)) & (np.linalg.det(a) != 0)
        found: Any = np.linalg.solve(np.where(regular[:, None, None], a, np.eye(a.shape[1])), b)
    found[~regular] = np.nan
    return np.asarray(found)
