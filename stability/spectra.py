"""Eigenvalues with error discs, and the verdict they allow, for any family of any system.

Each eigenvalue carries a bound on its own error, from running error analysis of the graph and
Gershgorin's theorem after diagonalisation; a verdict is given only where those bounds decide.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import DomainError, ParameterError
from .families import Family
from .modes import Modes, lift, mode_labels, track
from .reduction import Place, Reduced
from .tracked import TINY, UNIT
from .verdict import BY_CODE, CODES, Nonlinear, Verdict

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


GROWS = -2
"""In place of a verdict's flag value where structural zeros are not semisimple."""
NOT_ASKED = -1
"""In place of bits where a verdict stands as double precision gave it."""
NOT_STEADY = -2
"""In place of bits where a rate is proved not to vanish at the root of the equations."""


def in_words(bits: int) -> str:
    """What arithmetic a proof took.

    Parameters
    ----------
    bits
        Precision of the balls, 0 for rational arithmetic.
    """
    return f"balls of {bits} bits" if bits else "rational arithmetic"


@dataclass(frozen=True, eq=False)
class Proof:
    """How the certified points of a spectrum were proved."""

    abscissa_error: Floats
    """Proved bound on the error of the abscissa, shape (…)."""
    bits: NDArray[np.int64]
    """Precision of the balls that decided each verdict, 0 for rational arithmetic, shape (…);
    `NOT_ASKED` where double precision decided."""
    escalated: bool = False
    """Whether only those points were certified that double precision left undecided."""

    def sentence(self, *, certified: bool) -> str:
        """How far the proof of a single spectrum came, in words."""
        if self.bits == NOT_STEADY:
            return "no steady motion: at the root of the equations another rate is not zero"
        far = "proved" if certified else "undecided within the budget of precision"
        return f"{far} in {in_words(int(self.bits))}"


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Eigenvalues of the linearisation at members of a family, structural zeros removed.

    Leading axes are parameters; the last axis is the mode.

    Source: this package; each number has an independent oracle in tests/test_spectrum.py.

    Examples
    --------
    >>> import stability as st
    >>> s = st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3))
    >>> s.verdict.word, round(float(s.abscissa), 6), s.structural_zeros
    ('stable', -0.142586, 2)
    """

    family: Family
    """The family."""
    at: Floats
    """Family parameters, shape (…, len(family.at))."""
    eigenvalues: Complexes
    """Sorted by real, then imaginary part, shape (…, n) [1/s, or √(g/R)]."""
    radius: Floats
    """Error bound of each eigenvalue, shape (…, n): all of them lie in the union of these discs."""
    structural_zeros: int
    """How many eigenvalues are left out: zero by structure at every point asked, the least number
    where points differ."""
    codes: NDArray[np.int8]
    """Verdict as flag values (`Verdict.code`), shape (…)."""
    states: Floats
    """The steady motions, dimensionless, shape (…, states)."""
    place: Place
    """Where the members are, dimensionless, one row per point."""
    rate: Floats
    """Unit of the eigenvalues in dimensionless ones, shape (…) or () [1/s]."""
    scale: Floats
    """Unit of each state, shape (…, states)."""
    proof: Proof | None = None
    """How verdicts and eigenvalues were proved, where they were."""
    grows: NDArray[np.bool_] | None = None
    """Where the structural zeros are proved not to be semisimple, shape (…); None where every
    one of them is a tangent of the family."""
    note: str = ""
    """A sentence on structural zeros, where there are fewer here than at typical members."""

    def __repr__(self) -> str:
        shape = self.eigenvalues.shape[:-1]
        what = self.verdict.word if not shape else f"{shape} points"
        return f"<Spectrum of {self.family.name}: {what}, {self.eigenvalues.shape[-1]} eigenvalues>"

    @property
    def abscissa(self) -> Any:
        """Largest real part of the eigenvalues, shape (…); a float for a single spectrum."""
        value = self.eigenvalues.real.max(axis=-1)
        return float(value) if value.ndim == 0 else value

    @property
    def certified(self) -> Any:
        """Whether the verdict is proved, in rational arithmetic or balls, shape (…)."""
        if self.proof is None:
            value = np.zeros(self.codes.shape, dtype=bool)
        else:
            value = (self.codes != CODES[Verdict.UNDECIDED]) & (self.proof.bits != NOT_ASKED)
        return bool(value) if value.ndim == 0 else value

    @property
    def abscissa_error(self) -> Any:
        """Bound on the error of the abscissa, shape (…)."""
        real = self.eigenvalues.real
        # the difference first: it is exact where it matters
        value = (self.radius + (real - real.max(axis=-1, keepdims=True))).max(axis=-1)
        if self.proof is not None:
            value = self.proof.abscissa_error
        return float(value) if value.ndim == 0 else value

    @property
    def verdict(self) -> Any:
        """`Verdict`, or an object array of them, shape (…)."""
        return _members(self.codes, BY_CODE)

    @property
    def nonlinear(self) -> Any:
        """`Nonlinear`, or an object array of them, shape (…): what the motion itself does."""
        harmless = self.structural_zeros == self.family.tangents
        stable = Nonlinear.ASYMPTOTIC if harmless else Nonlinear.OPEN
        if self.family.drifts:
            stable = Nonlinear.DRIFTS
        # Neutral with every λ² strictly negative: the integrals confine the motion.
        kept = Nonlinear.BY_INTEGRALS if self.family.integrals else Nonlinear.OPEN
        table = {
            CODES[Verdict.STABLE]: stable,
            CODES[Verdict.UNSTABLE]: Nonlinear.UNSTABLE,
            CODES[Verdict.NEUTRAL]: kept,
            CODES[Verdict.UNDECIDED]: Nonlinear.OPEN,
        }
        on_zero = (self.codes == CODES[Verdict.NEUTRAL]) & (
            np.abs(self.eigenvalues) <= self.radius
        ).any(axis=-1)
        codes = np.where(on_zero, CODES[Verdict.UNDECIDED], self.codes)
        if self.grows is not None:
            table[GROWS] = Nonlinear.GROWS
            known = np.isin(codes, [c for c, told in table.items() if told is Nonlinear.OPEN])
            asked = known & (self.codes != CODES[Verdict.UNDECIDED])
            codes = np.where(self.grows & asked, GROWS, codes)
        return _members(np.asarray(codes), table)

    @property
    def reason(self) -> str:
        """One sentence on how the verdict was reached, or why it was not; for a single spectrum."""
        if self.codes.ndim:
            raise ParameterError("reason is for a single spectrum; ask for one point.")
        bound = f"largest real part {self.abscissa:.3g}, error bound {self.abscissa_error:.1g}"
        if self.family.conservative and not self.certified:
            bound = "decided by the sign of λ², whose polynomial is even by structure; " + bound
        parts = [bound]
        if self.proof is not None and self.proof.bits != NOT_ASKED:
            parts = [self.proof.sentence(certified=self.certified), bound]
            if self.proof.escalated:
                parts.insert(0, "double precision left it open")
        elif self.structural_zeros:
            count = self.structural_zeros
            parts.append(
                f"{count} structural zero{'s' * (count != 1)} removed through null vectors"
            )
        return "; ".join([*parts, *filter(None, [self.note])])

    @cached_property
    def modes(self) -> Modes:
        """Eigenvectors and readable labels, in the order of the eigenvalues."""
        values = self.eigenvalues / np.asarray(self.rate)[..., None]
        reduced = self.place.reduced(self.family, self.structural_zeros)
        vectors, participation = lift(values, reduced, self.scale)
        labels = mode_labels(
            self.eigenvalues, self.radius, participation, self.family.system.states
        )
        return Modes(vectors, participation, labels)

    def tracked(self) -> NDArray[np.intp]:
        """Order that follows each mode along the last parameter axis, by eigenvector overlap.

        Returns
        -------
        ndarray
            Indices of shape (…, points, n): `np.take_along_axis(s.eigenvalues, s.tracked(), -1)`
            has one mode per column.  Where eigenvalues meet, which of them goes on is a convention.

        Examples
        --------
        >>> import numpy as np, stability as st
        >>> s = st.spectrum("spinning", at=np.linspace(2, 3, 9), contact=st.Viscous(0.3))
        >>> s.tracked().shape
        (9, 5)
        """
        if not self.codes.ndim:
            raise ParameterError("tracked is for a branch; give `at` as an array.")
        return track(self.eigenvalues, self.modes.vectors)


def _members(codes: NDArray[np.int8], table: dict[int, Any]) -> Any:
    if codes.ndim == 0:
        return table[int(codes)]
    out = np.empty(codes.shape, dtype=object)
    for code, member in table.items():
        out[codes == code] = member
    return out


# --- eigenvalues and their error ---


def eigenvalues(reduced: Reduced, *, even: bool) -> tuple[Complexes, Floats]:
    """Eigenvalues with error bounds, sorted by real, then imaginary part.

    Parameters
    ----------
    reduced
        From `reduce`.
    even
        Whether the characteristic polynomial is even by structure; then λ² is computed, and real
        and imaginary parts come out as exact as the structure has them.

    Returns
    -------
    values, radius
        Shapes (N, m).  The exact eigenvalues lie in the union of the discs, and a connected part
        of the union made of j discs holds j of them (Gershgorin); for an even polynomial the same
        holds of each λ separately.

    Raises
    ------
    DomainError
        If the linearisation is not finite.
    """
    if not reduced.matrix.shape[-1]:
        raise DomainError("every eigenvalue is zero by structure; there is no spectrum to judge.")
    if not np.isfinite(reduced.matrix).all():
        raise DomainError(
            "the linearisation overflows double precision; give values nearer to 1 "
            "(dimensionless mu, at and 1/k below 1e100)."
        )
    with np.errstate(all="ignore"):  # what overflows comes out as a disc without bound
        values, radius = _even(reduced) if even else _general(reduced.matrix, reduced.error)
        radius = np.where(np.isfinite(radius), radius, np.inf)
    if not np.isfinite(values).all():
        raise DomainError("the eigenvalues overflow double precision; give values nearer to 1.")
    order = np.lexsort((values.imag, values.real), axis=-1)
    return np.take_along_axis(values, order, -1), np.take_along_axis(radius, order, -1)


def _general(matrix: Floats, error: Floats) -> tuple[Complexes, Floats]:
    """LAPACK's eigenvalues, with Gershgorin discs of X⁻¹(B + E)X - Λ.

    The residual BX - XΛ is computed, so LAPACK's own backward error is measured, not assumed.
    Where it is large (balancing can do that to a matrix with a tiny entry) X is refined once.
    """
    found = np.linalg.eig(matrix)
    values, x = found[0].astype(complex), found[1].astype(complex)
    radius, excess = _discs(matrix, error, values, x)
    poor = np.flatnonzero(excess > 8)
    if len(poor):
        better = _refined(matrix[poor], values[poor], x[poor])
        discs, _ = _discs(matrix[poor], error[poor], *better)
        gain = discs.max(axis=-1) < radius[poor].max(axis=-1)
        values[poor[gain]], radius[poor[gain]] = better[0][gain], discs[gain]
    return values, radius


def _discs(matrix: Floats, error: Floats, values: Complexes, x: Complexes) -> tuple[Floats, Floats]:
    """Gershgorin radii, and how far the residual stands above its own rounding error."""
    size = matrix.shape[-1]
    with np.errstate(all="ignore"):
        y: Complexes = _inverse(x)
        ax, ay = np.abs(x), np.abs(y)
        residual = np.abs(matrix @ x - x * values[:, None, :])
        # rounding of that residual: each entry is a sum of `size` products and one more
        terms = np.abs(matrix) @ ax + ax * np.abs(values)[:, None, :]
        rough = (size + 3) * (UNIT * terms + TINY) + error @ ax
        radius = (ay @ (residual + rough)).sum(axis=-1) + size * TINY
        flaw = np.abs(y @ x - np.eye(size)).sum(axis=-1).max(axis=-1)
        flaw += size * UNIT * (ay @ ax).sum(axis=-1).max(axis=-1)
        radius = radius / np.where(flaw < 0.5, 1 - flaw, 0.0)[:, None]
        excess = residual.max(axis=(1, 2)) / rough.max(axis=(1, 2))
    radius[~np.isfinite(radius)] = np.inf
    return radius, excess


def _refined(matrix: Floats, values: Complexes, x: Complexes) -> tuple[Complexes, Complexes]:
    """One step of Newton's method on all eigenpairs at once.

    Source: T. Ogita & K. Aishima, Japan J. Indust. Appl. Math. 35 (2018) 1007-1035, in its plain
    form for a matrix without symmetry.
    """
    with np.errstate(all="ignore"):
        near = _inverse(x) @ (matrix @ x)
        new = np.einsum("ijj->ij", near).copy()
        gap = new[:, None, :] - new[:, :, None]
        np.einsum("ijj->ij", gap)[...] = 1.0
        shift = near / gap
        np.einsum("ijj->ij", shift)[...] = 0.0
        vectors = x + x @ shift
    new = np.where(values.imag == 0, new.real, new)
    return new, vectors


def _inverse(x: Complexes) -> Complexes:
    try:
        return np.asarray(np.linalg.inv(x), dtype=complex)
    except np.linalg.LinAlgError:  # some row is exactly defective: that row has no bound
        out = np.full_like(x, np.nan)
        for index in range(len(x)):
            try:
                out[index] = np.linalg.inv(x[index])
            except np.linalg.LinAlgError:
                continue
        return out


def _even(reduced: Reduced) -> tuple[Complexes, Floats]:
    """Eigenvalues of a matrix whose characteristic polynomial is even by structure."""
    if reduced.matrix.shape[-1] == 2:
        return _one_square(reduced.matrix, reduced.error)
    # With λ also -λ̄ is an eigenvalue.  A disc that meets the imaginary axis is put symmetric to it;
    # if it then keeps clear of all others it holds one eigenvalue, which is its own mirror image.
    values, radius = _general(reduced.matrix, reduced.error)
    near = np.abs(values.real) <= radius
    radius = np.where(near, radius + np.abs(values.real), radius)
    return np.where(near, 1j * values.imag, values), radius


def _one_square(matrix: Floats, error: Floats) -> tuple[Complexes, Floats]:
    """±√z with z = λ² = (tr B²)/2, since the trace of the 2 × 2 matrix is zero by structure."""
    square = matrix @ matrix
    z = 0.5 * (square[:, 0, 0] + square[:, 1, 1])
    a, e = np.abs(matrix), error
    slack = a @ e + e @ a + e @ e + 4 * UNIT * (a @ a) + 8 * TINY
    bound = 0.5 * (slack[:, 0, 0] + slack[:, 1, 1]) + UNIT * np.abs(z)
    root = np.sqrt(z.astype(complex))
    size = np.maximum(np.abs(root), 1e-300)
    # |√z - √z'| ≤ min(r/|√z|, √r): the bound of a simple root, and the one at zero
    spread = np.minimum(bound / size, np.sqrt(bound))
    both: Floats = np.stack([spread, spread], axis=-1)
    return np.stack([root, -root], axis=-1), both


# --- verdict ---


def decide(values: Complexes, radius: Floats, *, even: bool) -> NDArray[np.int8]:
    """Verdicts from eigenvalues and their discs, as flag values.

    Parameters
    ----------
    values, radius
        From `eigenvalues`, shapes (N, m).
    even
        Whether the polynomial is even by structure.

    Returns
    -------
    ndarray
        Shape (N,).
    """
    with np.errstate(all="ignore"):
        return _decide_even(values, radius) if even else _decide(values, radius)


def _decide(values: Complexes, radius: Floats) -> NDArray[np.int8]:
    real = values.real
    stable = (real + radius < 0).all(axis=1)
    right = real - radius > 0
    # Discs wholly in Re > 0 that no other disc touches hold as many eigenvalues as there are discs.
    distance = np.abs(values[:, :, None] - values[:, None, :])
    touching = distance <= radius[:, :, None] + radius[:, None, :]
    mixed = (touching & right[:, :, None] & ~right[:, None, :]).any(axis=(1, 2))
    unstable = right.any(axis=1) & ~mixed
    codes = np.zeros(len(values), dtype=np.int8)
    codes[stable] = CODES[Verdict.STABLE]
    codes[unstable] = CODES[Verdict.UNSTABLE]
    return codes


def _decide_even(values: Complexes, radius: Floats) -> NDArray[np.int8]:
    """By λ²: on the imaginary axis with a disc that keeps clear of zero and of every other disc."""
    distance = np.abs(values[:, :, None] - values[:, None, :])
    reach = radius[:, :, None] + radius[:, None, :]
    np.einsum("ijj->ij", distance)[...] = np.inf
    alone = (distance > reach).all(axis=(1, 2))
    # An isolated λ² whose disc meets the real axis is real, since the polynomial in λ² is real.
    neutral = alone & (np.abs(values.real) <= radius).all(axis=1)
    unstable = alone & (values.real - radius > 0).any(axis=1)
    codes = np.zeros(len(values), dtype=np.int8)
    codes[neutral] = CODES[Verdict.NEUTRAL]
    codes[unstable] = CODES[Verdict.UNSTABLE]
    return codes
