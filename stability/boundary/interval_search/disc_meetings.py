"""Meetings of the eigenvalues of a block with the imaginary axis, over a piece, in doubles.

Over a piece the matrix is A + t B + t² C + E with t from -1 to 1, and a bound on each entry of E.
It is carried to the eigenvectors at the middle, where it is nearly diagonal.  A Hermitian form S
with G* S + S G negative definite leaves no eigenvalue of G on the imaginary axis: such an
eigenvector v has v* (G* S + S G) v = 0.  The form is affine in t and t², so that the corners of
their box prove it for all t (Cholesky's factors with an a priori bound).  By its inertia it also
keeps an eigenvalue to the right of a line all along; the verdict is then known.

Where the form fails, Gershgorin's discs show which eigenvalues may meet the axis.  A disc alone
holds one eigenvalue at every t.  Its eigenvectors are near unit vectors, with bounds from their
equations row by row.  These bound its derivative, w G' v / (w v).  Where the real part is monotone,
its signs at both ends tell whether it meets the axis.  An eigenvalue that is zero by structure is
the only one in its disc.

Source: A. Ostrowski, H. Schneider, J. Math. Anal. Appl. 4 (1962) 72-84 (the form);
S. M. Rump, BIT 46 (2006) 433-452 (Cholesky); J. H. Wilkinson, The Algebraic Eigenvalue Problem
(1965), ch. 2; tests/boundary/test_large_boundaries.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from flint import acb, acb_mat, arb, arb_series

from ...algebra.eigenvalue_discs import LOST, MORE, SAFE, basis_of, near_diagonal
from ...algebra.krawczyk import NotProvedError
from ...algebra.number_types import precision, upper
from ...algebra.running_error import TINY, UNIT
from ...base.types import Complexes, Floats
from ...polynomials.identities import MOST_STATES
from ...spectra.verdict_routes import BITS
from ..brackets import AxisScan, Crossing
from .meetings import MOST_PIECES, GraphMeetings, NoValueError, around, middle_of
from .taylor import coefficient, entries_of, terms

MOST_WORK = 800_000
"""Largest number of pieces times the square of the number of states."""
STEPS = 12
"""Most steps of Newton's method to the root of a piece."""
CLOSE = 2.0**-60
"""Last step, over the root."""
TINIEST = 1e-200
"""Size of a diagonal entry below which nothing is proved."""
LARGEST = 1e200
"""Size of an entry from which nothing is proved."""


class Span(NamedTuple):
    """A block over a piece: A + t B + t² C + E."""

    middle: Floats
    """A."""
    error: Floats
    """Bound on the error of A alone."""
    slope: Floats
    """B."""
    curve: Floats
    """C."""
    rest: Floats
    """Bound on E, with the error of A."""
    bend: Floats
    """Bound on the derivative of t² C + E; infinite where there is none."""


class Suspect(NamedTuple):
    """An eigenvalue that may meet the imaginary axis."""

    value: complex
    """The eigenvalue at the middle."""
    vector: Complexes
    """Its eigenvector."""
    place: float
    """The t at which it meets the axis, to first order."""
    crosses: bool
    """Whether its real part changes sign, proved; otherwise it stays off the axis."""


class PieceDiscs(NamedTuple):
    """What discs prove of a piece."""

    suspects: list[Suspect]
    """Eigenvalues that may meet the axis."""

    @property
    def meetings(self) -> int | None:
        """Number of meetings with the axis, a pair counted once; None where it is not proved."""
        crossing = [disc.value.imag for disc in self.suspects if disc.crosses]
        pairs, alone = divmod(sum(v != 0 for v in crossing), 2)
        return None if alone else pairs + sum(v == 0 for v in crossing)


# --- proofs over a piece ---


class Carried:
    """A block over a piece in the basis of its eigenvectors at the middle.

    Its diagonal is `centre` + t `turn` up to `inner`; `off` bounds the other entries.  `radius`
    is that of the discs at any t, and `still` at the middle.

    Raises
    ------
    NotProvedError
        If the eigenvectors are not proved to be a basis.
    """

    def __init__(self, span: Span) -> None:
        n = len(span.middle)
        values, vectors = np.linalg.eig(span.middle)
        self.values, self.vectors = values.astype(complex), vectors.astype(complex)
        basis = basis_of(self.vectors, np.linalg.inv(self.vectors))
        if basis is None:
            raise NotProvedError
        near, doubt = near_diagonal(basis, span.middle, span.error, self.values)
        slope, blur = basis.similar(span.slope, np.zeros((n, n)))
        curve, sway = basis.similar(span.curve, span.rest)
        _, twist = basis.similar(np.zeros((n, n)), span.bend)
        self.tables = np.diag(self.values) + near, slope, curve
        rounding = 8 * UNIT * (np.abs(self.values) + np.abs(np.diag(near)))
        self.error = MORE * (doubt + blur + sway + np.diag(rounding))
        self.blur = MORE * (blur + twist)
        self.centre, self.turn = (np.diag(table).copy() for table in self.tables[:2])
        whole = np.abs(near) + np.abs(slope) + np.abs(curve) + self.error
        aside, still = np.abs(near) + doubt, np.diag(self.error + np.abs(curve))
        for table in (whole, aside):
            np.fill_diagonal(table, 0.0)
        self.inner = MORE * (still + 4 * UNIT * (np.abs(self.centre) + np.abs(self.turn)))
        self.off = MORE * whole
        self.radius = MORE * (self.inner + self.off.sum(axis=1))
        self.still = MORE * (np.diag(doubt) + rounding + aside.sum(axis=1))

    def clear(self, line: float = 0.0) -> bool:
        """Whether no eigenvalue has a given real part all along."""
        shift = line * np.eye(len(self.values))
        side = np.sign(self.centre.real - line)[:, None]
        error = self.error + 4 * UNIT * (np.abs(self.centre) + abs(line)) * np.eye(len(side))
        tables = [side * (self.tables[0] - shift), *(side * table for table in self.tables[1:])]
        return _definite(tables, error)

    def aside(self, zeros: int) -> bool:
        """Whether all discs but that of a zero by structure are off the axis, and off its disc."""
        zero = np.argsort(np.abs(self.centre))[:zeros].tolist()
        off = np.abs(self.centre.real) - np.abs(self.turn.real) > SAFE * self.radius
        off[zero] = True
        return bool(off.all() and all(map(self.alone, zero)))

    def lost(self, zeros: int) -> bool:
        """Whether an eigenvalue is so near the axis that no narrower piece decides, in doubles."""
        kept = np.argsort(np.abs(self.centre))[zeros:]
        near = np.abs(self.centre.real) + np.abs(self.turn.real) <= 4 * self.still
        return bool(near[kept].any())

    def unstable(self) -> bool:
        """Whether an eigenvalue has a positive real part all along."""
        real = np.sort(self.centre.real)
        right = real[real > 0]
        if not len(right):
            return False
        left = np.append(0.0, right[:-1])
        widest = np.argmax(right - left)
        return self.clear(left[widest] + (right[widest] - left[widest]) / 2)

    def gaps(self, i: int) -> Floats:
        """Distances of the centre of one disc from all others, at any t; infinite from itself."""
        far = np.abs(self.centre - self.centre[i]) - np.abs(self.turn - self.turn[i])
        far[i] = np.inf
        return np.asarray(far)

    def alone(self, i: int) -> bool:
        """Whether a disc meets no other at any t."""
        return bool((self.gaps(i) > SAFE * (self.radius + self.radius[i])).all())

    def ends(self, i: int) -> tuple[int, int] | None:
        """Signs at both ends of the real part of an eigenvalue alone, monotone between; or None."""
        others = np.arange(len(self.centre)) != i
        gap = (self.gaps(i) - self.inner - SAFE * self.radius[i])[others]
        if not (gap > 0).all():
            return None
        off = self.off[np.ix_(others, others)]
        right = _entries(self.off[others, i], off, gap)
        left = _entries(self.off[i, others], off.T, gap)
        if right is None or left is None:
            return None
        size = np.abs(self.tables[1]) + self.blur
        doubt = left @ size[others, i] + size[i, others] @ right
        doubt += left @ size[np.ix_(others, others)] @ right + self.blur[i, i]
        share, rate = MORE * float(left @ right), self.turn[i]
        if not share < 0.5:
            return None
        doubt = MORE * (doubt + np.abs(rate) * (share + 4 * UNIT)) / (1 - share)
        if not np.abs(rate.real) > doubt:
            return None
        middle, doubt = self.centre[i].real, MORE * (doubt + self.still[i])
        ends = middle - rate.real, middle + rate.real
        if not (np.abs(ends) > doubt).all():
            return None
        return int(np.sign(ends[0])), int(np.sign(ends[1]))


def _definite(tables: Sequence[Any], error: Floats) -> bool:
    """Whether T + T* is positive definite for T = A + t B + t² C within an error at every t."""
    centre, turn, bow = tables
    size = sum(np.abs(table) for table in tables)
    off = MORE * (error + 4 * UNIT * size)
    corners = [centre + turn, centre - turn]
    if bow.any():
        corners += [corner + bow for corner in corners]
    return all(_positive(table + table.conj().T, off + off.T) for table in corners)


def _positive(matrix: Any, error: Floats) -> bool:
    """Whether every Hermitian matrix within an error is positive definite."""
    diagonal = np.diag(matrix).real
    if not (np.isfinite(matrix).all() and np.isfinite(error).all() and (diagonal > TINIEST).all()):
        return False
    scale = np.exp2(-np.round(np.log2(diagonal) / 2))
    matrix, error = (scale[:, None] * some * scale for some in (matrix, error))
    n = len(matrix)
    rounding = 16 * (n + 4) * UNIT * np.trace(matrix).real
    shift = MORE * (error.sum(axis=1).max() + rounding + n * LOST)
    try:
        np.linalg.cholesky(matrix - shift * np.eye(n))
    except np.linalg.LinAlgError:
        return False
    return True


def _carried(span: Span) -> Carried | None:
    with suppress(NotProvedError, np.linalg.LinAlgError):
        return Carried(span)
    return None


def discs(carried: Carried, zeros: int) -> PieceDiscs | None:
    """Which eigenvalues meet the axis; None where this is not proved.

    Parameters
    ----------
    carried
        The block.
    zeros
        Number of its eigenvalues that are zero by structure, 0 or 1.
    """
    centre, turn = carried.centre, carried.turn
    reach = np.abs(centre.real) - np.abs(turn.real)
    off = np.flatnonzero(~(reach > SAFE * carried.radius))
    if zeros:
        zero = int(np.argmin(np.abs(centre)))
        if carried.values[zero].imag != 0 or not carried.alone(zero):
            return None
        off = off[off != zero]
    suspects = []
    for i in off.tolist():
        ends = carried.ends(i) if carried.alone(i) else None
        real = carried.values[i].imag == 0
        aside = np.abs(centre[i].imag) - np.abs(turn[i].imag) > SAFE * carried.radius[i]
        if ends is None or not (real or aside):
            return None
        place = float(np.clip(-centre[i].real / turn[i].real, -1, 1))
        value, vector = complex(carried.values[i]), carried.vectors[:, i]
        suspects.append(Suspect(value, vector, place, ends[0] != ends[1]))
    return PieceDiscs(suspects)


def _entries(first: Floats, table: Floats, gap: Floats) -> Floats | None:
    """Bounds on the entries of an eigenvector but its largest, which is 1; None without a proof."""
    shares = MORE * table.sum(axis=1) / gap
    most = shares.max(initial=0.0)
    if not most < 0.5:
        return None
    largest = MORE * (first / gap).max(initial=0.0) / (1 - most)
    return np.asarray(MORE * (first / gap + largest * shares))


@dataclass
class DiscPiece:
    """A piece of the axis with the linearisation there."""

    low: float
    high: float
    box: list[Any]
    """The unknowns over the piece, each the only root of the equations nearby."""
    span: Span
    """The whole matrix."""


class DiscMeetings(GraphMeetings):
    """Meetings by Hermitian forms and discs; by polynomials where doubles end, of few states."""

    def __init__(self, line: AxisScan, zeros: int) -> None:
        super().__init__(line, zeros)
        self.ended: set[tuple[float, float]] = set()
        self.left = super().most if self.small else 0

    def divisible(self, low: float, high: float) -> bool:
        """Whether narrower pieces may be proved where one is not."""
        return (low, high) not in self.ended

    @property
    def most(self) -> int:
        """Largest number of pieces."""
        return min(MOST_PIECES, MOST_WORK // max(map(len, self.blocks)) ** 2)

    def clear(self, value: float) -> bool:
        """Whether no eigenvalue is on the imaginary axis at a point, proved."""
        unknowns = self.root(value)
        if unknowns is None:
            return False
        with precision(BITS):
            matrix, error = self._tables(arb(value), unknowns, 1)[0]
        if not (np.isfinite(matrix).all() and np.isfinite(error).all()):
            return False
        none = np.zeros_like(matrix)
        whole = Span(matrix, error, none, none, error, none)
        with np.errstate(all="ignore"):
            every = [_carried(span) for span in self._spans(whole)]
        if all(carried is not None and carried.aside(self.zeros) for carried in every):
            return True
        return self.small and super().clear(value)

    @cached_property
    def small(self) -> bool:
        """Whether polynomials may decide what discs leave open."""
        return max(map(len, self.blocks)) <= MOST_STATES

    def _spans(self, whole: Span) -> list[Span]:
        return [Span(*(v[np.ix_(some, some)] for v in whole)) for some in self.blocks]

    def _tables(self, place: Any, start: list[Any], count: int) -> list[tuple[Floats, Floats]]:
        """Taylor coefficients of the linearisation in doubles, and bounds on their errors."""
        with terms(count):
            a, q = self.line.numbers_at(arb_series([place, 1]))
            entries = entries_of(self.family, a, q, start, count)
        rows, columns = np.array(self.family.graph.matrix.places[0]).reshape(-1, 2).T
        size = len(self.family.system.states)
        out = []
        for k in range(count):
            balls = [coefficient(entry, k) for entry in entries]
            middle, error = np.zeros((size, size)), np.zeros((size, size))
            middle[rows, columns] = [float(ball.mid()) for ball in balls]
            error[rows, columns] = [float(ball.rad()) for ball in balls]
            out.append((middle, MORE * error + 2 * (UNIT * np.abs(middle) + TINY)))
        return out

    def piece(self, low: float, high: float) -> Any:
        """Members and the linearisation over a piece."""
        middle, half, whole = around(low, high)
        here, box = self.members(low, high)
        inner, outer = self._tables(middle, here, 3), self._tables(whole, box, 4)
        step = upper(half)
        with np.errstate(all="ignore"):
            powers = (1.0, step, step * step, step * step * step)
            matrix, slope, curve = (c * v for c, (v, _) in zip(powers, inner, strict=False))
            error, *more = (c * e for c, (_, e) in zip(powers, inner, strict=False))
            blur, sway = (
                e + 8 * UNIT * np.abs(v) for e, v in zip(more, (slope, curve), strict=True)
            )
            last = powers[3] * (np.abs(outer[3][0]) + outer[3][1])
            rest = MORE * (error + blur + sway + last) + TINY
            bend = MORE * (blur + 2 * (np.abs(curve) + sway) + 3 * last) + TINY
            if not (np.isfinite(curve).all() and np.isfinite(rest).all()):
                matrix, error = outer[0]
                slope = curve = np.zeros_like(matrix)
                rest, bend = error, np.full_like(matrix, np.inf)
        if not (np.isfinite(rest).all() and max(np.abs(matrix).max(), rest.max()) < LARGEST):
            raise NoValueError
        return DiscPiece(low, high, box, Span(matrix, error, slope, curve, rest, bend))

    def zeros_in(self, piece: DiscPiece) -> int | None:
        """Number of meetings on a piece, each simple; None if this is not proved."""
        open_blocks = self._open_blocks(piece)
        if open_blocks is not None:
            return sum(seen.meetings or 0 for _, seen in open_blocks)
        if (piece.low, piece.high) not in self.ended or not self.left:
            return None
        self.left -= 1
        self.ended.remove((piece.low, piece.high))
        return super().zeros_in(super().piece(piece.low, piece.high))

    def _open_blocks(self, piece: DiscPiece) -> list[tuple[list[int], PieceDiscs]] | None:
        """The blocks that forms leave open, with what discs prove of them."""
        open_blocks = []
        with np.errstate(all="ignore"):  # what overflows proves nothing
            every = [_carried(span) for span in self._spans(piece.span)]
            if not self.every and any(
                carried is not None and carried.unstable() for carried in every
            ):
                return []
            for block, carried in zip(self.blocks, every, strict=True):
                if not self.zeros and carried and carried.clear():
                    continue
                seen = discs(carried, self.zeros) if carried else None
                if seen is None or seen.meetings is None:
                    if carried is None or carried.lost(self.zeros):
                        self.ended.add((piece.low, piece.high))
                    return None
                open_blocks.append((block, seen))
        return open_blocks

    def near(self, piece: DiscPiece) -> tuple[float, Crossing] | None:
        """The single meeting of a piece to double precision."""
        for block, seen in self._open_blocks(piece) or ():
            for suspect in seen.suspects:
                if suspect.crosses:
                    return self._polished(piece, block, suspect)
        return None

    def _polished(
        self, piece: DiscPiece, block: list[int], suspect: Suspect
    ) -> tuple[float, Crossing] | None:
        """The root of a real part, by Newton's method for eigenvalue, eigenvector and axis."""
        n, kind = len(block), Crossing.FLUTTER if suspect.value.imag else Crossing.STATIC
        with precision(BITS):
            middle = middle_of(piece.low, piece.high)
            place = arb(middle + suspect.place * (piece.high - piece.low) / 2)
            pair = acb_mat(n + 1, 1, [acb(complex(v)) for v in (*suspect.vector, suspect.value)])
            for _ in range(STEPS):
                if not piece.low <= place <= piece.high:
                    return None
                unknowns = self._unknowns(place, [float(v.mid()) for v in piece.box])
                table, slope = (
                    acb_mat([[m[i, j].mid() for j in block] for i in block])
                    for m in self._matrices(place, unknowns, 2)
                )
                step, way = _newton(table, slope, pair)
                back = -(pair[n, 0] + step[n, 0]).real / way[n, 0].real
                pair, place = (pair + step + way * back).mid(), (place + back).mid()
                if abs(back) <= CLOSE * abs(place):
                    return float(place), kind
        return None


def _newton(table: Any, slope: Any, pair: Any) -> tuple[Any, Any]:
    """Newton's step to an eigenvector and its eigenvalue, and their derivatives."""
    n = table.nrows()
    x, value = acb_mat(n, 1, pair.entries()[:n]), pair[n, 0]
    whole, right = acb_mat(n + 1, n + 1), acb_mat(n + 1, 2)
    off, turn = table * x - x * value, slope * x
    for i in range(n):
        for j in range(n):
            whole[i, j] = table[i, j]
        whole[i, i] -= value
        whole[i, n], whole[n, i] = -x[i, 0], x[i, 0].conjugate()
        right[i, 0], right[i, 1] = -off[i, 0], -turn[i, 0]
    both = whole.mid().solve(right.mid()).mid()
    return tuple(acb_mat(n + 1, 1, [both[i, k] for i in range(n + 1)]) for k in (0, 1))
