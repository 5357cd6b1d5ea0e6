"""Common zeros of two polynomials in Q[x, y]: candidates, and when two roots are one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

from flint import arb, arb_poly

from ....derivation.general.bounds import real_roots, univariate
from ..krawczyk import Values
from .planes import value_of


class PolynomialPair:
    """Two polynomials without common factor, with their slopes as a system of equations.

    Parameters
    ----------
    f, g
        Elements of `PLANE`.
    """

    def __init__(self, f: Any, g: Any) -> None:
        self.pair = f, g
        self._rows = [(p, p.derivative("x"), p.derivative("y")) for p in self.pair]

    def __call__(self, z: Values) -> tuple[Values, list[Values]]:
        """Values and rows of slopes at (x, y)."""
        found = [[value_of(p, *z) for p in row] for row in self._rows]
        return [row[0] for row in found], [row[1:] for row in found]

    @cached_property
    def sides(self) -> list[Any]:
        """Polynomials over Q whose roots hold x and y of every common zero: resultants."""
        f, g = self.pair
        return [univariate(f.resultant(g, name), i) for i, name in ((0, "y"), (1, "x"))]

    def near(self, roots: Sequence[Sequence[Any]]) -> Iterator[tuple[Any, Any]]:
        """Pairs of roots at which both polynomials may vanish.

        Parameters
        ----------
        roots
            Balls of x, and of y.
        """
        for x in roots[0]:
            rows = [arb_poly(_collapsed(p, x)) for p in self.pair]
            for y in roots[1]:
                if all(_horner(row, y).contains(0) for row in rows):
                    yield x, y


def same_root(polys: tuple[Any, Any], image: Any, place: Any) -> bool:
    """Whether two real roots are one: that of the first polynomial in a ball, of the other one.

    Parameters
    ----------
    polys
        Two polynomials over Q.
    image
        Ball of a root of the second one.
    place
        Ball of a root of the first one, and of no other.
    """
    common = [r for r in map(arb, real_roots(polys[0].gcd(polys[1]))) if r.overlaps(place)]
    return len(common) == 1 and all(
        sum(r.overlaps(common[0]) or r.overlaps(ball) for r in map(arb, real_roots(p))) == 1
        for p, ball in zip(polys, (place, image), strict=True)
    )


def _collapsed(p: Any, x: Any) -> list[Any]:
    """Coefficients in y at a ball of x."""
    powers = [arb(1)]
    for _ in range(p.degrees()[0]):
        powers.append(powers[-1] * x)
    out = [arb(0)] * (p.degrees()[1] + 1)
    for (i, j), c in p.to_dict().items():
        out[int(j)] += powers[int(i)] * c
    return out


def _horner(row: Any, y: Any) -> Any:
    total = arb(0)
    for c in reversed(row.coeffs()):
        total = total * y + c
    return total
