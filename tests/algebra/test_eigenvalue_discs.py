"""Proved discs about eigenvalues, against exact roots over Q and closed forms."""

from collections.abc import Callable

import numpy as np
import pytest
from flint import acb, arb, fmpq, fmpq_mat

from stability.algebra.eigensolver import eigensolver
from stability.algebra.eigenvalue_discs import Discs, eigenvalue_discs
from stability.algebra.number_types import precision

SEED = 20261128
Random = np.random.Generator


def exact(value: float) -> fmpq:
    return fmpq(*float(value).as_integer_ratio())


def true_roots(matrix: np.ndarray) -> list[tuple[object, int]]:
    """Every eigenvalue of a matrix of doubles to 60 digits, with its multiplicity, over Q."""
    poly = fmpq_mat([[exact(v) for v in row] for row in matrix]).charpoly()
    with precision(400):
        return poly.numer().complex_roots()


def check(discs: Discs, roots: list[tuple[object, int]]) -> None:
    """Each disc alone holds one root, each disc of a cluster all roots of the cluster."""
    if not np.isfinite(discs.radius).all():
        assert np.isinf(discs.radius).all()
        return
    with precision(400):
        inside = [
            sum(count for root, count in roots if abs(root - acb(c.real, c.imag)) <= arb(r))
            for c, r in zip(map(complex, discs.values), map(float, discs.radius), strict=True)
        ]
    gap = np.abs(discs.values[:, None] - discs.values)
    meets = gap <= discs.radius[:, None] + discs.radius
    for i, count in enumerate(inside):
        assert count == 1 if discs.alone[i] else 2 <= count <= meets[i].sum(), (i, count)
    assert not (meets & discs.alone & ~np.eye(len(meets), dtype=bool)).any()


def similar(random: Random, diagonal: np.ndarray, size: int) -> np.ndarray:
    """A matrix of whole numbers with the eigenvalues of a triangular one, exactly."""
    n = len(diagonal)
    low = np.tril(random.integers(-size, size + 1, (n, n)), -1) + np.eye(n, dtype=int)
    inverse = np.array(
        [[int(v.p) for v in row] for row in fmpq_mat(low.tolist()).inv().tolist()], dtype=object
    )
    found = low.astype(object) @ diagonal.astype(object) @ inverse
    return np.array(found, dtype=float)


def plain(random: Random, n: int) -> np.ndarray:
    return random.normal(size=(n, n))


def symmetric(random: Random, n: int) -> np.ndarray:
    found = random.integers(-9, 10, (n, n)).astype(float)
    return found + found.T


def badly_scaled(random: Random, n: int) -> np.ndarray:
    size = np.exp2(random.integers(-60, 60, n))
    return size[:, None] * random.normal(size=(n, n)) / size


def huge_and_small(random: Random, n: int) -> np.ndarray:
    return random.normal(size=(n, n)) * 10.0 ** random.integers(-120, 120, (n, n)).clip(-12, 12)


def far_from_normal(random: Random, n: int) -> np.ndarray:
    return np.triu(random.normal(size=(n, n)) * 30) + np.diag(random.normal(size=n)) * 1e-3


def clustered(random: Random, n: int) -> np.ndarray:
    near = 1 + random.integers(0, 4, n) * 2.0 ** -random.integers(10, 52)
    return np.diag(near) + 2.0**-30 * np.triu(random.normal(size=(n, n)), 1)


def defective(random: Random, n: int) -> np.ndarray:
    jordan = np.diag(random.integers(-2, 3, n)) + np.diag(random.integers(0, 2, n - 1), 1)
    return similar(random, jordan, 2)


def companion(random: Random, n: int) -> np.ndarray:
    found = np.diag(np.ones(n - 1), -1)
    found[:, -1] = random.integers(-5, 6, n)
    return found


def sparse(random: Random, n: int) -> np.ndarray:
    return np.where(random.random((n, n)) < 2 / n, random.normal(size=(n, n)), 0.0)


def moved(random: Random, n: int) -> np.ndarray:
    """A Jordan block with one entry of rounding in the corner."""
    found = np.eye(n, k=1)
    found[-1, 0] = 10.0 ** random.uniform(-18, -3)
    return found


def tiny(random: Random, n: int) -> np.ndarray:
    return plain(random, n) * 1e-190


def large(random: Random, n: int) -> np.ndarray:
    return badly_scaled(random, n) * 1e150


HOSTILE = (
    plain,
    symmetric,
    badly_scaled,
    huge_and_small,
    far_from_normal,
    clustered,
    defective,
    companion,
    sparse,
    moved,
    tiny,
    large,
)


def campaign(kind: Callable[[Random, int], np.ndarray], count: int, seed: int) -> int:
    """Check random matrices of a kind, and others within an error; how many have discs."""
    random, known = np.random.default_rng([seed, *map(ord, kind.__name__)]), 0
    for turn in range(count):
        matrix = kind(random, int(random.integers(2, 11)))
        error = np.zeros_like(matrix)
        if turn % 2:
            error = np.abs(matrix) * 2.0 ** -random.integers(15, 50)
        discs = eigenvalue_discs(matrix, error)
        check(discs, true_roots(matrix))
        if turn % 2:  # doubles within the error, most of them at its ends
            sign = random.choice([-1.0, 1.0, 0.5], matrix.shape)
            check(discs, true_roots(matrix + (1 - 1e-9) * sign * error))
        known += bool(np.isfinite(discs.radius).all())
    return known


@pytest.mark.parametrize("kind", HOSTILE, ids=lambda kind: kind.__name__)
def test_discs_hold_the_exact_roots(kind: Callable[[Random, int], np.ndarray]) -> None:
    known = campaign(kind, 14, SEED)
    if kind in (plain, symmetric, badly_scaled, companion, tiny, large):
        assert known >= 12


@pytest.mark.long
@pytest.mark.parametrize("kind", HOSTILE, ids=lambda kind: kind.__name__)
def test_many_discs_hold_the_exact_roots(kind: Callable[[Random, int], np.ndarray]) -> None:
    """Thousands of hostile matrices."""
    campaign(kind, 1500, SEED + 1)


def test_radii_are_a_few_roundings_of_the_values() -> None:
    """Sixty states to 60 digits; the solver's own error is 50 times as large."""
    matrix = np.random.default_rng(SEED).normal(size=(60, 60))
    discs = eigenvalue_discs(matrix, np.zeros_like(matrix))
    assert discs.alone.all()
    assert (discs.radius <= 2.3e-16 * np.abs(discs.values)).all()
    check(discs, true_roots(matrix))


def test_a_bad_eigensolver_costs_width_but_no_proof() -> None:
    matrix = np.random.default_rng(SEED).normal(size=(6, 6))

    def rough(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values, vectors = np.linalg.eig(matrices)
        return values * (1 + 1e-7), vectors + 1e-6 * np.abs(vectors)

    with eigensolver(rough):
        discs = eigenvalue_discs(matrix, np.zeros_like(matrix))
    assert np.isfinite(discs.radius).all()
    check(discs, true_roots(matrix))


def test_what_is_not_finite_or_defective_has_no_disc() -> None:
    none = np.zeros((3, 3))
    for matrix in (np.full((3, 3), np.nan), np.full((3, 3), np.inf), np.eye(3, k=1), none):
        assert np.isinf(eigenvalue_discs(matrix, none).radius).all()
    assert np.isinf(eigenvalue_discs(np.eye(3), np.full((3, 3), np.inf)).radius).all()
