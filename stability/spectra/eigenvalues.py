"""Eigenvalues with error discs, and the verdict from the discs, for any family of any system.

Each eigenvalue carries an error bound, from running error analysis of the graph and Gershgorin's
theorem after diagonalisation.  A verdict is given only where these bounds decide.

Modes are the eigenvectors over the states, with readable labels, and can be tracked.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..algebra.eigensolver import eigenpairs
from ..algebra.running_error import TINY, UNIT
from ..base.errors import DomainError
from ..base.printing import html_table
from ..base.types import Complexes, Floats
from ..base.verdict import CODES, Verdict
from .deflation import Reduced

STABLE, UNSTABLE, NEUTRAL = (CODES[v] for v in (Verdict.STABLE, Verdict.UNSTABLE, Verdict.NEUTRAL))
"""Flag values of verdicts."""
NOT_STEADY = -2
"""Value instead of bits, where a rate is proved nonzero at the root of the equations."""
BY_ACCIDENT = -3
"""Value instead of bits, where an eigenvalue is zero and it is open whether by structure."""
NO_PROOF_OF_ZERO = -4
"""Value instead of bits, where an eigenvalue seems to be zero by structure, without a proof."""
NO_PROOF_OF_BLOCKS = -6
"""Value instead of bits, where it is open whether zero eigenvalues form a Jordan block."""
REASONS = {
    NOT_STEADY: "no steady motion: at the root of the equations another rate is not zero",
    BY_ACCIDENT: "an eigenvalue is zero here, and nothing proves that it is structural",
    NO_PROOF_OF_ZERO: "an eigenvalue seems to be zero, and nothing proves that it is zero",
    NO_PROOF_OF_BLOCKS: "nothing proves whether the zero eigenvalues form a Jordan block",
}
"""Reason in words, for each of these values."""
POOR = 8
"""Ratio of a residual to its rounding error above which vectors are refined."""
SPARE = 2.0**-20
"""Share of a radius that the surplus of the counted roundings covers."""


# --- eigenvalues and their error ---


class Eigenpairs(NamedTuple):
    """Eigenvalues and eigenvectors of matrices, in any order and without bounds."""

    values: Complexes
    """Eigenvalues, shape (N, m)."""
    vectors: Complexes
    """Eigenvectors as columns, shape (N, m, m)."""


class Enclosed(NamedTuple):
    """Eigenvalues with error discs, and the eigensolver's pairs."""

    values: Complexes
    """Sorted by real, then imaginary part, shape (N, m)."""
    radius: Floats
    """Bound on the error of each eigenvalue, shape (N, m)."""
    pairs: Eigenpairs | None
    """Eigenpairs from the eigensolver; None where the values came from a formula."""


def eigenvalues(reduced: Reduced, *, even: bool) -> Enclosed:
    """Eigenvalues with error bounds, sorted by real, then imaginary part.

    Parameters
    ----------
    reduced
        Linearisation from `deflate`.
    even
        Whether the characteristic polynomial is even by structure.  Values and discs then use
        the symmetry of the spectrum.

    Returns
    -------
    Enclosed
        The exact eigenvalues lie in the union of the discs.  A connected part of the union made
        of j discs holds j of them (Gershgorin).

    Raises
    ------
    DomainError
        If the linearisation is not finite.
    """
    if not reduced.matrix.shape[-1]:
        raise DomainError("every eigenvalue is zero by structure; there is no spectrum to judge.")
    if not np.isfinite(reduced.matrix).all():
        raise DomainError(
            "the linearisation has no value there, or overflows double precision; give values "
            "nearer to 1."
        )
    with np.errstate(all="ignore"):  # an overflow gives an infinite disc
        enclosed = _even(reduced) if even else _general(reduced.matrix, reduced.error)
        values, radius, pairs = enclosed
        radius = np.where(np.isfinite(radius), radius, np.inf)
    if not np.isfinite(values).all():
        raise DomainError("the eigenvalues overflow double precision; give values nearer to 1.")
    order = np.lexsort((values.imag, values.real), axis=-1)
    return Enclosed(
        np.take_along_axis(values, order, -1), np.take_along_axis(radius, order, -1), pairs
    )


def _general(matrix: Floats, error: Floats) -> Enclosed:
    """The eigensolver's eigenvalues, with Gershgorin discs of X⁻¹(B + E)X - Λ.

    The residual BX - XΛ is computed, so the solver's error is measured, not assumed.  X is refined
    once where the residual is large (LAPACK's balancing can cause this for a tiny entry).
    """
    values, x = eigenpairs(matrix)
    radius, excess = _discs(matrix, error, values, x)
    poor = np.flatnonzero(excess > POOR)
    if len(poor):
        better = _refined(matrix[poor], values[poor], x[poor])
        discs, _ = _discs(matrix[poor], error[poor], *better)
        gain = discs.max(axis=-1) < radius[poor].max(axis=-1)
        values[poor[gain]], radius[poor[gain]] = better[0][gain], discs[gain]
        x[poor[gain]] = better[1][gain]
    return Enclosed(values, radius, Eigenpairs(values, x))


def _discs(matrix: Floats, error: Floats, values: Complexes, x: Complexes) -> tuple[Floats, Floats]:
    """Gershgorin radii, and the ratio of the residual to its rounding error."""
    size = matrix.shape[-1]
    with np.errstate(all="ignore"):
        y: Complexes = _inverse(x)
        ax, ay = np.abs(x), np.abs(y)
        residual = np.abs(matrix @ x - x * values[:, None, :])
        # rounding of the residual: each entry is a sum of `size` products and one more
        terms = np.abs(matrix) @ ax + ax * np.abs(values)[:, None, :]
        rough = (size + 3) * (UNIT * terms + TINY) + error @ ax
        sums = (ay @ (residual + rough)).sum(axis=-1) + size * TINY
        flaw = np.abs(y @ x - np.eye(size)).sum(axis=-1).max(axis=-1)
        flaw += size * UNIT * (ay @ ax).sum(axis=-1).max(axis=-1)
        radius = sums / np.where(flaw < 0.5, 1 - flaw, 0.0)[:, None]
        excess = residual.max(axis=(1, 2)) / rough.max(axis=(1, 2))
        # a flaw of y mixes the rows: a bad vector reaches the discs of the good ones
        mixed = flaw[:, None] * radius.max(axis=-1, keepdims=True)
        radius = np.where((mixed > SPARE * radius) | (excess > POOR)[:, None], sums + mixed, radius)
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
    except np.linalg.LinAlgError:  # some matrix is exactly defective and gets no bound
        out = np.full_like(x, np.nan)
        for index in range(len(x)):
            try:
                out[index] = np.linalg.inv(x[index])
            except np.linalg.LinAlgError:
                continue
        return out


def _even(reduced: Reduced) -> Enclosed:
    """Eigenvalues of a matrix whose characteristic polynomial is even by structure."""
    if reduced.matrix.shape[-1] == 2:
        return _one_square(reduced.matrix, reduced.error)
    values, radius, pairs = _general(reduced.matrix, reduced.error)
    return Enclosed(*on_the_axis(values, radius), pairs)


def on_the_axis(values: Complexes, radius: Floats) -> tuple[Complexes, Floats]:
    """Discs of a symmetric spectrum, those that meet the imaginary axis symmetric to it.

    If λ is an eigenvalue, -λ̄ is one too.  If no other disc touches a disc that is symmetric to the
    axis, its one eigenvalue is its own mirror image.
    """
    near = np.abs(values.real) <= radius
    radius = np.where(near, radius + np.abs(values.real), radius)
    return np.where(near, 1j * values.imag, values), radius


def _one_square(matrix: Floats, error: Floats) -> Enclosed:
    """±√z with z = λ² = (tr B²)/2, since the trace of the 2 × 2 matrix is zero by structure."""
    square = matrix @ matrix
    z = 0.5 * (square[:, 0, 0] + square[:, 1, 1])
    a, e = np.abs(matrix), error
    slack = a @ e + e @ a + e @ e + 4 * UNIT * (a @ a) + 8 * TINY
    bound = 0.5 * (slack[:, 0, 0] + slack[:, 1, 1]) + UNIT * np.abs(z)
    root = np.sqrt(z.astype(complex))
    size = np.maximum(np.abs(root), 1e-300)
    # |√z - √z'| ≤ min(r/|√z|, √r): the bound of a simple root, and the bound at zero
    spread = np.minimum(bound / size, np.sqrt(bound))
    both: Floats = np.stack([spread, spread], axis=-1)
    return Enclosed(np.stack([root, -root], axis=-1), both, None)


# --- verdict ---


def decide(values: Complexes, radius: Floats, *, even: bool) -> NDArray[np.int8]:
    """Verdicts from eigenvalues and their discs, as flag values.

    Parameters
    ----------
    values, radius
        Eigenvalues and radii from `eigenvalues`, shapes (N, m).
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
    codes[stable] = STABLE
    codes[unstable] = UNSTABLE
    return codes


def _alone(values: Complexes, radius: Floats) -> NDArray[np.bool_]:
    """Whether no two discs meet."""
    distance = np.abs(values[:, :, None] - values[:, None, :])
    reach = radius[:, :, None] + radius[:, None, :]
    np.einsum("ijj->ij", distance)[...] = np.inf
    return np.asarray((distance > reach).all(axis=(1, 2)))


def _decide_even(values: Complexes, radius: Floats) -> NDArray[np.int8]:
    """Verdicts where no two discs meet: all on the imaginary axis, or some clear to its right."""
    alone = _alone(values, radius)
    # an isolated λ whose disc meets the imaginary axis lies on it, since -λ̄ is an eigenvalue too
    neutral = alone & (np.abs(values.real) <= radius).all(axis=1)
    unstable = alone & (values.real - radius > 0).any(axis=1)
    codes = np.zeros(len(values), dtype=np.int8)
    codes[neutral] = NEUTRAL
    codes[unstable] = UNSTABLE
    return codes


def unstable_in_discs(values: Complexes, radius: Floats, *, even: bool) -> NDArray[np.int16]:
    """Number of unstable eigenvalues, -1 where a disc meets the imaginary axis; as `decide`."""
    with np.errstate(all="ignore"):
        off = np.abs(values.real) > radius
        decided = off.all(axis=1)
        if even:  # a disc alone that meets the axis holds an eigenvalue on it
            decided |= (off | (values.real == 0)).all(axis=1) & _alone(values, radius)
        right = (values.real > radius).sum(axis=1)
    return np.where(decided, right, -1).astype(np.int16)


class Modes(NamedTuple):
    """Eigenvectors of the linearisation, in the order of the eigenvalues."""

    vectors: Complexes
    """Unit vectors over the states, shape (…, mode, state), in the units of the spectrum."""
    participation: Floats
    """Share of each state in each mode, shape (…, mode, state); each mode sums to 1."""
    labels: NDArray[np.object_] | tuple[str, ...]
    """Readable names, shape (…, mode); a tuple for a single spectrum."""
    states: tuple[str, ...] = ()
    """Names of the states."""

    def __repr__(self) -> str:
        *shape, modes, states = self.vectors.shape
        if shape:
            where = " x ".join(map(str, shape))
            return f"<Modes of {where} points, {modes} each, over {states} states>"
        return f"<Modes, {modes} over {states} states: {'; '.join(self.labels)}>"

    def _repr_html_(self) -> str:
        if self.vectors.ndim > 2:
            return html_table(repr(self)[1:-1], [], [])
        shares = [[f"{share:.3g}" for share in row] for row in self.participation]
        columns = [
            "mode",
            *(f"share of {name}" for name in self.states or range(self.vectors.shape[-1])),
        ]
        rows = [[label, *row] for label, row in zip(self.labels, shares, strict=True)]
        return html_table(repr(self)[1:-1].partition(":")[0], columns, rows)


def lift(
    eigenvalues: Complexes, reduced: Reduced, pairs: Eigenpairs, scale: Floats
) -> tuple[Complexes, Floats]:
    """Eigenvectors over the states, and each state's share, in the order of the eigenvalues.

    Parameters
    ----------
    eigenvalues
        Dimensionless, shape (…, mode).
    reduced
        The linearisation without structural zeros, one row per point.
    pairs
        Eigenvalues and eigenvectors of `reduced`, in any order.
    scale
        Unit of each state, broadcastable to (…, states).

    Returns
    -------
    vectors, participation
        Shapes (…, mode, state).
    """
    shape = eigenvalues.shape
    values = eigenvalues.reshape(pairs.values.shape)
    pick = _match(values, pairs.values)
    w = np.take_along_axis(pairs.vectors, pick[:, None, :], axis=2)
    for step in reversed(reduced.steps):
        # (r·w, λ w) up to a factor; at λ = 0 a mode may coincide with the removed direction
        head = (step.row[:, :, None] * w).sum(axis=1)
        size = np.maximum(np.abs(head), np.abs(values))
        alone = size < 1e-300
        size = np.where(alone, 1.0, size)
        first = head / size
        rest = np.where(alone, 1.0, values / size)
        tail = w * rest[:, None, :] + step.multipliers[:, :, None] * first[:, None, :]
        full = np.concatenate([first[:, None, :], tail], axis=1)
        w = np.empty_like(full)
        np.put_along_axis(w, step.order[:, :, None], full, axis=1)
    vectors = np.swapaxes(w, 1, 2)
    vectors = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    share = np.abs(vectors) ** 2
    units = np.broadcast_to(scale, (*shape[:-1], vectors.shape[-1]))
    lifted = vectors.reshape(*shape, -1) * units[..., None, :]
    lifted = lifted / np.linalg.norm(lifted, axis=-1, keepdims=True)
    return lifted, share.reshape(*shape, -1)


def _match(values: Complexes, reference: Complexes) -> NDArray[np.intp]:
    """Place of the nearest given eigenvalue for each value; each place is used once."""
    distance = np.abs(values[:, :, None] - reference[:, None, :])
    pick: NDArray[np.intp] = distance.argmin(axis=2)
    twice = np.flatnonzero((np.sort(pick, axis=1) != np.arange(values.shape[1])).any(axis=1))
    if len(twice):
        from scipy.optimize import linear_sum_assignment

        for row in twice:
            pick[row] = linear_sum_assignment(distance[row])[1]
    return pick


def mode_labels(values: Complexes, radius: Floats, share: Floats, states: tuple[str, ...]) -> Any:
    """Names such as `growing oscillation of q, v`: kind of motion, and its leading states.

    A word on growth is there where the error disc leaves no doubt.
    """
    flat, r, s = (
        array.reshape(-1, *array.shape[values.ndim - 1 :]) for array in (values, radius, share)
    )
    labels = np.empty(flat.shape, dtype=object)
    for row in np.ndindex(flat.shape):
        value = flat[row]
        what = "oscillation" if abs(value.imag) > r[row] else "mode"
        sure = "growing " if value.real > r[row] else "decaying " if value.real < -r[row] else ""
        kind = f"{sure}{what}" if sure or what == "oscillation" else "slow mode"
        lead = np.argsort(-s[row], kind="stable")
        count = 1 if s[row][lead[0]] > 0.8 else 2
        labels[row] = f"{kind} of {', '.join(states[i] for i in sorted(lead[:count]))}"
    labels = labels.reshape(values.shape)
    return tuple(labels) if values.ndim == 1 else labels


def track(values: Complexes, vectors: Complexes) -> NDArray[np.intp]:
    """Order that follows each mode along the second-last axis, by eigenvector overlap.

    Parameters
    ----------
    values
        Eigenvalues, shape (…, points, n).
    vectors
        Unit eigenvectors, shape (…, points, n, states).

    Returns
    -------
    ndarray
        Indices, shape (…, points, n).

    Examples
    --------
    >>> v = np.array([[1.0, 2.0], [2.1, 1.1]], dtype=complex)
    >>> e = np.array([np.eye(2), np.eye(2)[::-1]], dtype=complex)
    >>> track(v, e).tolist()
    [[0, 1], [1, 0]]
    """
    from scipy.optimize import linear_sum_assignment

    count = values.shape[-1]
    flat_values = values.reshape(-1, *values.shape[-2:])
    flat_vectors = vectors.reshape(-1, *vectors.shape[-3:])
    order = np.empty(flat_values.shape, dtype=np.intp)
    for line, (lam, vec) in enumerate(zip(flat_values, flat_vectors, strict=True)):
        order[line, 0] = np.arange(count)
        size = np.abs(lam).max() + 1e-300
        for point in range(1, len(lam)):
            last = order[line, point - 1]
            overlap = np.abs(vec[point - 1][last].conj() @ vec[point].T)
            jump = np.abs(lam[point - 1][last][:, None] - lam[point][None, :])
            # overlap decides; distance decides where vectors are alike, as near equal eigenvalues
            order[line, point] = linear_sum_assignment((1 - overlap) + 4 * jump / size)[1]
    return order.reshape(values.shape)
