"""Proof that a motion converges to one steady motion: its family along y, the deviation e across.

Near a family of steady motions ė = G(y, e) and ẏ = g(y, e), where G and g vanish at e = 0.  With
e = X z and J̃ an enclosure of X⁻¹ ∂G/∂e X on a box Y x E, |z| falls at the rate

    β = -max_i sup (J̃_ii + ½ Σ_{j≠i} |J̃_ij + J̃_ji|)

while the motion is in the box, and w = y - ℓᵀe obeys |ẇ| ≤ Γ |z|, Γ = sup |(∂g/∂e - ℓᵀ∂G/∂e) X|.
From |z| = r and w within η of y_c, y therefore stays within η + Γ r/β + |ℓᵀX| r of y_c.  Where that
is no more than the half-width δ of Y, and e = X z, |z| ≤ r, fits in E, the motion never leaves the
box: it converges to one steady motion, which lies within η + Γ r/β of y_c.  Each entry of y has its
own ℓ, η, Γ and δ.  The guards are positive on the box, so that no guard ends the motion.

A member that stands alone has no y, and need not be known exactly: where G(0) is within X ρ of zero
and β r > ρ, the box holds exactly one steady motion, within ρ/β of e = 0, and all motions of the
box converge to it (the contraction of all distances at the rate β).

Every bound is taken in ball arithmetic from the graph, with π/2 as an exact symbol;
tests/settling/test_settling.py derives the bound for the disk independently,
tests/motion/test_system_motion.py checks systems with known basins.

Many states are tried at once in balls of doubles, by the compiled loops of `box_kernel.py`: the
same box and the same inequality.  The basis is the real modal basis of a member nearby, by LAPACK;
launches with the same parameters share the bases of members on a grid.  One whose proof just
misses tries the two bases of the single test, each its own.  Any basis is sound: its inverse is
enclosed.  Where Numba is missing NumPy runs the same functions, with the same results to the last
bit of each bound.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..algebra.eigensolver import eigenpairs, eigenvalues_alone
from ..algebra.kernels import double_balls
from ..algebra.kernels.compiled import compiled
from ..algebra.kernels.double_balls import UP
from ..algebra.kernels.tape import LANES, Tape, recorded
from ..algebra.number_types import Algebra, balls, precision
from ..base.errors import StabilityError
from ..base.types import Floats
from . import box_kernel as kernel
from .surroundings import Surroundings

BITS = 64
"""Precision of the balls: their width comes from the box, not from rounding."""
TURNS = 10
"""Widenings of the box after which the test gives up."""
WIDEN = 1.1
"""Factor on the half-width that is found to be needed."""
ROOM = 4
"""Extra room of the first box, over the size that a remainder needs."""
KERNELS: tuple[ModuleType, ...] = (double_balls, kernel)
MOST = 60
"""Most states across a family for which the roundings are bounded."""
STEP = 2.0**-12
"""Spacing of the members whose bases launches share."""
APART = 0.05
"""Largest part of the slowest rate by which a shared basis may change a launch's slopes."""
JUST = 4.0
"""Rates by which a proof may miss and is tried again, in the launch's own two bases."""
NEARER, MARGIN, NEAREST = 0.6, 0.8, 0.05
"""Part of the distance where the next proof may succeed: without an estimate, over the estimate,
and at least."""
SPARE = 2.0**-46
"""Half-width of the first box along the family, over the size of its centre: above rounding."""
Bases = tuple[NDArray[np.bool_], Floats, Floats, Floats]
"""Whether the members near launches are stable, Z, X, and the slowest rates."""


@dataclass(frozen=True)
class Attraction:
    """A box from which no motion escapes, and the steady motion that it converges to."""

    limit: tuple[float, ...]
    """Parameters y of a member near that steady motion."""
    error: float
    """Bound on the distance of the limit from that motion: of y, or of the states without y."""
    rate: float
    """Least rate at which the deviation falls, in the norm of the basis."""
    reach: float
    """Half the diagonal of the box across the family."""


@precision(BITS)
def attraction(
    around: Surroundings, arguments: Sequence[float], y: Sequence[Any], e: Sequence[Any]
) -> Attraction | None:
    """A box around a state in which its motion is proved to converge to one steady motion.

    Parameters
    ----------
    around
        The family's surroundings.
    arguments
        Second argument of its programs.
    y, e
        Parameters of the nearest member and deviation, as balls that contain the true values.

    Returns
    -------
    Attraction or None
        None where the test fails.
    """
    m = around.across
    y1, e1 = [float(v.mid()) for v in y], np.array([float(v.mid()) for v in e])
    centre, slow = y1, np.zeros((len(y), m))
    a = np.zeros((m, m))
    for _ in range(3):
        both = around.slopes.arrays([centre, list(arguments), [0.0] * m], ())[0]
        a, along = both[:m], both[m:]
        if not np.isfinite(both).all() or np.linalg.matrix_rank(a) < m:
            return None
        slow = np.array([np.linalg.solve(a.T, row) for row in along]).reshape(len(y), m)
        centre = [c - float(row @ e1) for c, row in zip(y1, slow, strict=True)]
    if not (eigenvalues_alone(a).real < 0).all():
        return None
    for basis in (_modal(a[None])[2][0], _lyapunov_basis(a)):
        if basis is not None:
            box = _box(around, arguments, y, e, centre, slow, basis)
            if box is not None:
                return box
    return None


def _lyapunov_basis(a: Floats) -> Floats | None:
    """The basis in which the symmetric part of A is diagonal, from AᵀP + PA = -1."""
    from scipy.linalg import solve_continuous_lyapunov

    with np.errstate(all="ignore"):
        try:
            p = solve_continuous_lyapunov(a.T, -np.eye(len(a)))
            levels, q = np.linalg.eigh((p + p.T) / 2)
        except (ValueError, np.linalg.LinAlgError):
            return None
    if not (np.isfinite(levels).all() and levels[0] > 0):
        return None
    basis: Floats = q / np.sqrt(levels)
    return basis


def _box(
    around: Surroundings,
    arguments: Sequence[float],
    y: Sequence[Any],
    e: Sequence[Any],
    centre: list[float],
    slow: Floats,
    basis: Floats,
) -> Attraction | None:
    """The test of the module's docstring in one basis."""
    from flint import arb, arb_mat

    m, n = around.across, around.along
    x = arb_mat(basis.tolist())
    try:
        inverse = x.inv()
    except ZeroDivisionError:
        return None
    held, column = [arb(float(v)) for v in arguments], arb_mat([[v] for v in e])
    z = inverse * column
    r, rho = _length([z[i, 0] for i in range(m)]), arb(0)
    if around.remainder is not None:
        rest = around.remainder.dense(balls(), [[], held, [arb(0)] * m])
        off = inverse * arb_mat(rest)
        rho = _length([off[i, 0] for i in range(m)])
        r = (r + ROOM * rho / _slowest(basis, around, arguments) + arb(2) ** -BITS).abs_upper()
    across = [_length([x[i, j] for j in range(m)]) * r for i in range(m)]
    box = [arb(0, v.abs_upper()) for v in across]
    rows = [arb_mat([row.tolist()]) for row in slow]
    eta = [
        (v - (row * column)[0, 0] - arb(c)).abs_upper()
        for v, row, c in zip(y, rows, centre, strict=True)
    ]
    sideways = [_length([(row * x)[0, j] for j in range(m)]) * r for row in rows]
    delta = [
        (2 * (off + side) + arb(2) ** -60 * (1 + abs(arb(c)))).abs_upper()
        for off, side, c in zip(eta, sideways, centre, strict=True)
    ]
    for _ in range(TURNS):
        wide = [arb(c, d) for c, d in zip(centre, delta, strict=True)]
        blocks = [wide, held, box]
        if not all(v > 0 for v in around.positive.run(balls(), blocks)[0]):
            return None
        dense = around.slopes.dense(balls(), blocks)
        j = inverse * arb_mat(dense[:m]) * x
        beta = -_largest(j)
        if not (beta > 0 if around.remainder is None else beta * r > rho):
            return None
        error, needed = [], []
        for i in range(n):
            drift = (arb_mat([dense[m + i]]) - rows[i] * arb_mat(dense[:m])) * x
            error.append(eta[i] + _length([drift[0, k] for k in range(m)]) * r / beta)
            needed.append((error[i] + sideways[i]).abs_upper())
        if all(v <= d for v, d in zip(needed, delta, strict=True)):
            half = _length(across)
            if around.remainder is not None:
                size = _length([_length([x[i, k] for k in range(m)]) for i in range(m)])
                error = [size * rho / beta]
            return Attraction(
                tuple(centre),
                max((float(v.abs_upper()) for v in error), default=0.0),
                float(beta.mid()),
                float(half.mid()),
            )
        delta = [(WIDEN * v).abs_upper() for v in needed]
    return None


def _slowest(basis: Floats, around: Surroundings, arguments: Sequence[float]) -> float:
    """The rate at which deviations fall at the member itself, in double precision."""
    a = around.slopes.arrays([[], list(arguments), [0.0] * around.across], ())[0]
    j = np.linalg.solve(basis, a @ basis)
    return max(float(-np.linalg.eigvalsh((j + j.T) / 2).max()), 1e-300)


def _length(entries: list[Any]) -> Any:
    """An upper bound of the Euclidean length."""
    return sum((v * v for v in entries), 0 * entries[0]).abs_upper().sqrt().abs_upper()


def _largest(j: Any) -> Any:
    """Upper bound of the largest eigenvalue of the symmetric part, by Gershgorin's theorem."""
    n = j.nrows()
    rows = [j[i, i] + sum(abs(j[i, k] + j[k, i]) for k in range(n) if k != i) / 2 for i in range(n)]
    highest = rows[0]
    for value in rows[1:]:
        highest = highest.max(value)
    return highest.upper()


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

    def put(self, rows: NDArray[np.intp], other: Settled) -> None:
        """Write the proofs of some launches, whose families may have fewer states y."""
        self.limit[rows, : other.limit.shape[1]] = other.limit
        for name in ("proved", "error", "rate", "reach", "nearer"):
            getattr(self, name)[rows] = getattr(other, name)


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
    arguments: Floats,
    e: Balls,
    settled: Settled,
    left: NDArray[np.bool_],
    *,
    plain: bool = False,
) -> None:
    """Write down which launches are proved to converge by a box about each.

    Parameters
    ----------
    around, y, arguments, e, plain
        As for `stability.settling.settling.settled`.
    settled
        Where proofs are written.
    left
        Launches that are tried, shape (launches,).

    Raises
    ------
    StabilityError
        If the family's graph has a function without a kernel, such as exp.
    """
    test = _Test(
        around, tapes(around), y, arguments, e, settled, plain, np.zeros(len(arguments), bool)
    )
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
    arguments: Floats
    e: Balls
    settled: Settled
    plain: bool
    just: NDArray[np.bool_]
    """Which launches are proved, or nearly."""

    def slopes(self, y: Floats, arguments: Floats) -> Floats:
        """∂G/∂e and ∂g/∂e at members, shape (launches, m + n, m)."""
        m, n = self.around.across, self.around.along
        points = np.concatenate([y, arguments, np.zeros((len(y), m))], axis=1)
        mid, _ = self.made.box.run(points.T, plain=self.plain)
        slopes: Floats = mid[: (m + n) * m].T.reshape(-1, m + n, m)
        return slopes

    def centres(self, left: NDArray[np.bool_]) -> tuple[Any, Floats, Floats, Floats]:
        """Launches, centres y_c = y - ℓᵀe, rows ℓ with ℓᵀA = ∂g/∂e there, and A."""
        m = self.around.across
        whole = np.isfinite(np.hstack([self.y.mid, self.arguments, self.e.mid])).all(1)
        some = np.flatnonzero(whole & left)
        y, e, arguments = self.y.mid[some], self.e.mid[some], self.arguments[some]
        centre, slow, a = y, np.zeros((len(y), self.around.along, m)), np.zeros((len(y), m, m))
        for _ in range(3):
            both = self.slopes(centre, arguments)
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
        places = np.column_stack([np.rint(centre[:, 0] / STEP), self.arguments[some]])
        nodes, rows = np.unique(places, axis=0, return_inverse=True)
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
        again = self.just[some] & ~self.settled.proved[some]
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
        arguments = _lanes(self.arguments[some])
        f, kappa, r, eta, rows, turned = loops.start(z, x, ell, y, ry, e[:, None], re[:, None], c)
        rho = np.zeros_like(r)
        if made.rest is not None:
            rho, slowest = self._remainder(loops, arguments, z, x)
            r = (r + ROOM * rho / slowest) * UP + 2.0**-64
        across, sideways = rows * r * UP, turned * r * UP
        delta = 2 * (eta + sideways) + SPARE * (1 + np.abs(c))
        for turn in range(TURNS):
            mid, rad = np.zeros((2, made.box.inputs, len(some)))
            mid[: len(c)], mid[len(c) : -m], rad[: len(c)], rad[-m:] = c, arguments, delta, across
            mid, rad = made.box.run(mid, rad, plain=self.plain)
            cut = (len(c) + m) * m
            j, rj = (v[:cut].reshape(-1, m, len(some)) for v in (mid, rad))
            beta, error = loops.turn(z, x, ell, j, rj, f, kappa, r, eta)
            if not turn:  # the rate of a box falls in proportion to its size, about
                share = np.maximum(MARGIN * rate / (rate - beta), NEAREST)
                before = np.where(self.just[some], self.settled.nearer[some], 0.0)
                self.settled.nearer[some] = np.maximum(np.where(beta < 0, share, NEARER), before)
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
            c, ell, z, x, arguments, f, kappa, r, eta, across, sideways, rho, rows = (
                np.ascontiguousarray(v[..., go])
                for v in (c, ell, z, x, arguments, f, kappa, r, eta, across, sideways, rho, rows)
            )

    def _remainder(
        self, loops: Any, arguments: Floats, z: Floats, x: Floats
    ) -> tuple[Floats, Floats]:
        """|Z G| at e = 0, and the rate at which deviations fall there, in double precision."""
        m, made = self.around.across, self.made
        points = np.vstack([arguments, np.zeros((m, arguments.shape[1]))])
        assert made.rest is not None
        rest, off = (v[:, None] for v in made.rest.run(points, plain=self.plain))
        moved, wide = np.zeros_like(rest), np.zeros_like(rest)
        loops.product(z, rest, off, moved, wide)
        zs, xs = np.moveaxis(z, -1, 0), np.moveaxis(x, -1, 0)
        j = zs @ self.slopes(np.zeros((len(zs), 0)), arguments.T) @ xs
        highest = np.linalg.eigvalsh((j + j.swapaxes(1, 2)) / 2).max(1)
        return loops.length(moved[:, 0], wide[:, 0]), np.maximum(-highest, 1e-300)

    def _keep(self, some: Any, c: Floats, error: Floats, beta: Floats, across: Floats) -> None:
        settled = self.settled
        settled.proved[some], settled.limit[some] = True, c.T
        settled.error[some] = error.max(0)
        settled.rate[some], settled.reach[some] = beta, np.sqrt((across * across).sum(0))


def _lanes(v: Floats) -> Floats:
    """An array with its launches along the last axis."""
    return np.ascontiguousarray(np.moveaxis(v, 0, -1))


def _modal(a: Floats) -> Bases:
    """Whether matrices are stable, their real modal bases Z and X = Z⁻¹, and their slowest rates.

    The columns of X are real and imaginary parts of the eigenvectors.
    """
    stable, values, vectors, rate = eigen(a)
    x = real_basis(values, vectors)
    z = _solved(x, np.broadcast_to(np.eye(x.shape[1]), x.shape))
    return stable & np.isfinite(z).all((1, 2)), z, x, rate


def real_basis(values: Any, vectors: Any) -> Floats:
    """Real and imaginary parts of eigenvectors, as columns in the place of each pair."""
    basis: Floats = np.where(values.imag[:, None] < 0, vectors.imag, vectors.real)
    return basis


def _lyapunov(a: Floats) -> Bases:
    """As `_modal`, by the bases in which the symmetric part of A is diagonal: AᵀP + PA = -1.

    With A = V Λ V⁻¹ entry (i, j) of VᴴPV is that of VᴴV over -(λ̄_i + λ_j).
    """
    stable, values, v, rate = eigen(a)
    w = _solved(v, np.broadcast_to(np.eye(v.shape[1]), v.shape))
    falls = -(values.conj()[:, :, None] + values[:, None, :])
    p = (w.conj().swapaxes(1, 2) @ (v.conj().swapaxes(1, 2) @ v / falls) @ w).real
    stable &= np.isfinite(p).all((1, 2))
    levels, q = np.linalg.eigh(np.where(stable[:, None, None], p, 0.0))
    stable &= (levels > 0).all(1)
    root = np.sqrt(np.where(stable[:, None], levels, 1.0))[:, None]
    return stable, (q * root).swapaxes(1, 2), q / root, rate


def eigen(a: Floats) -> tuple[NDArray[np.bool_], Any, Any, Floats]:
    """Whether matrices are stable, eigenvalues, eigenvectors, and slowest rates."""
    whole: Any = np.isfinite(a).all((1, 2))
    values, vectors = eigenpairs(np.where(whole[:, None, None], a, 0.0))
    rate = -values.real.max(1, initial=-np.inf)
    return whole & (rate > 0), values, vectors, rate


def _solved(a: Floats, b: Floats) -> Floats:
    """Solutions of many linear systems, nan where the matrix is singular."""
    with np.errstate(all="ignore"):
        regular: Any = np.isfinite(a).all((1, 2)) & (np.linalg.det(a) != 0)
        solution: Any = np.linalg.solve(np.where(regular[:, None, None], a, np.eye(a.shape[1])), b)
    solution[~regular] = np.nan
    return np.asarray(solution)
