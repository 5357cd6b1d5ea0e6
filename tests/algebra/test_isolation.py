"""Real roots by halving, against Flint's isolation and against roots that are put in."""

from __future__ import annotations

import random

import pytest
from flint import arb, fmpq, fmpz_poly

from stability.algebra.exact.roots import halved_roots
from stability.algebra.number_types import precision


def with_roots(roots: list[fmpq]) -> fmpz_poly:
    """The polynomial over Z with these roots and none else."""
    p = fmpz_poly([1])
    for root in roots:
        p *= fmpz_poly([-int(root.p), int(root.q)])
    return p


def sizes() -> list[tuple[str, list[fmpq]]]:
    """Roots on both sides, at 0, at dyadic numbers, close together and far apart in size."""
    ten = fmpq(10)
    tiny, near = 1 / ten**600, 1 + 1 / ten**300
    return [
        ("one", [fmpq(1)]),
        ("at halves", [fmpq(-3, 4), fmpq(1, 2), fmpq(1), fmpq(3, 2), fmpq(2), fmpq(4)]),
        ("with 0", [fmpq(0), fmpq(1, 3), fmpq(-1, 3)]),
        ("far apart", [tiny, -2 * tiny, fmpq(1), ten**300, 3 * ten**300]),
        ("close", [fmpq(1), near, 2 - near, -near, fmpq(7, 5)]),
    ]


@pytest.mark.few(5)
@pytest.mark.parametrize("roots", [r for _, r in sizes()], ids=[n for n, _ in sizes()])
@pytest.mark.parametrize("bits", [64, 1200])
def test_roots_that_are_put_in_are_found(roots: list[fmpq], bits: int) -> None:
    p = with_roots(roots) * fmpz_poly([1, 1, 1]) * fmpz_poly([5, 0, 7])  # and four complex ones
    with precision(bits):
        found = halved_roots(p)
        assert len(found) == len(roots)
        for ball in found:
            assert any(ball.contains(arb(r)) for r in roots)
            assert ball == 0 or ball.rad() <= abs(ball).mid() * arb(2) ** (2 - bits)
        if bits > 1000:  # enough to separate the close ones: each ball holds a root of its own
            held = [[r for r in roots if b.contains(arb(r))] for b in found]
            assert sorted(r for (r,) in held) == sorted(roots)


def test_it_finds_what_flint_finds() -> None:
    draw = random.Random(20261122)
    met = 0
    for _ in range(300):
        p = fmpz_poly([draw.randint(-(2**40), 2**40) for _ in range(draw.randint(2, 9))])
        p = p // p.gcd(p.derivative()) if p.degree() > 0 else fmpz_poly([1, 1])
        theirs = sorted((r.real for r, _ in p.complex_roots() if r.imag == 0), key=float)
        ours = sorted(halved_roots(p), key=float)
        assert len(ours) == len(theirs)
        met += len(ours)
        assert all(a.overlaps(b) for a, b in zip(ours, theirs, strict=True))
    assert met > 400
