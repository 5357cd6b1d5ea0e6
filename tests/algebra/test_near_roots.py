"""Roots far nearer to each other than doubles: factored, or in clusters that hold them."""

import pytest
from flint import acb_poly, arb, fmpq, fmpq_poly

from stability.algebra.exact.roots import bounded_roots, exact_roots, isolated
from stability.algebra.number_types import precision

NEAR = fmpq(1, 2**1074)


def line(root: fmpq) -> fmpq_poly:
    return fmpq_poly([-root, 1])


@pytest.mark.parametrize("routine", [exact_roots, bounded_roots])
def test_rational_roots_5e_324_apart(routine: object) -> None:
    planted = [fmpq(-1), fmpq(-1) - NEAR, fmpq(-2), fmpq(-3), fmpq(-3)]
    whole = fmpq_poly([1])
    for root in planted:
        whole = whole * line(root)
    with precision(3000):
        found = routine(whole * fmpq_poly([2, 2, 1]) * fmpq_poly([2 + NEAR, 2, 1]))  # type: ignore[operator]
        real = sorted((r.real for r in found if r.imag == 0), key=lambda r: r.mid())
        pairs = [r for r in found if r.imag != 0]
        assert len(found) == 9
        for ball, root in zip(real, sorted(planted), strict=True):
            assert ball.contains(arb(root))
        for square in (fmpq(1), 1 + NEAR):  # (λ + 1)² = -1 and -(1 + 5e-324)
            high = [r for r in pairs if r.imag > 0 and r.imag.overlaps(arb(square).sqrt())]
            assert len(high) == 1
            assert high[0].real.contains(-1)


@pytest.mark.parametrize("base", [[1, 3, 1, 1], [1, 3, 1, 1, 1], [1, 3, 1, 1, 1, 2, 1]])
def test_clusters_hold_roots_that_no_factor_parts(base: list[int]) -> None:
    """b(λ)² = 2 (5e-324)²: its roots are those of b ± √2 5e-324, here at 9000 bits."""
    half = fmpq_poly(base)
    found = bounded_roots(half * half - fmpq_poly([2 * NEAR * NEAR]))
    assert len(found) == 2 * (len(base) - 1)
    assert all(r.real.rad() < 1e-15 and r.imag.rad() < 1e-15 for r in found)
    with precision(9000):
        shift = arb(2).sqrt() * arb(NEAR)
        for sign in (1, -1):
            true = acb_poly([arb(base[0]) + sign * shift, *base[1:]]).roots(tol=arb(2) ** -5000)
            for root in true:
                assert sum(ball.contains(root) for ball in found) >= 2


@pytest.mark.parametrize("bits", [64, 128, 512])
def test_roots_that_are_far_apart_are_isolated_whatever_the_scale(bits: int) -> None:
    """A bead's sine of its angle, along its turning rate: FLINT's iteration alone fails at 12 %."""
    failed = 0
    for k in range(200):
        with precision(bits):
            v = (arb(k + 10) / 20) ** 4
            balls = [c * arb(2) ** 98 for c in (-v / 4, -v, arb(96.2361) - 3 * v / 4, v, v)]
            found = isolated(balls, even=False)
            assert found is not None and len(found) == 4
            p = acb_poly(balls)
            assert all(p(r).contains(0) and r.rad() < 1e-12 for r in found)
            real = [r for r in found if r.imag == 0]
            assert len(real) == (2 if (k + 10) / 20 < 6.6015 else 4)  # two are born at 6.60159
            try:
                p.roots()
            except ValueError:
                failed += 1
    assert failed > 5  # otherwise this test says nothing
