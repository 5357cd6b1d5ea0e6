"""Which real root of a polynomial a straight line of parameters leads to: by discriminants alone.

Between two roots of the discriminant (or of the leading coefficient) along a line, the real roots
keep their order and number.  At such a root those that come together or go to infinity end.
Shares no code with the package: Flint isolates the roots over Q, mpmath gives 40 digits.
"""

from typing import Any

import mpmath as mp
import sympy as sp
from flint import ctx, fmpq, fmpq_poly

X, P, Q = sp.symbols("x p q")
NEAR = mp.mpf(10) ** -12
"""Share of the line next to a special point at which roots are compared."""
TOGETHER = 1e-3
"""Distance below which two roots next to a special point come together there."""
FAR = 1e5
"""Size above which a root next to a special point goes to infinity there."""


class Sheets:
    """The real roots x of a polynomial f(x, p, q) over lines in (p, q)."""

    def __init__(self, f: Any) -> None:
        poly = sp.Poly(f, X)
        special = [sp.discriminant(f, X) if poly.degree() > 1 else sp.Integer(1), poly.LC()]
        self.special = [
            [(i, j, fmpq(int(c.p), int(c.q))) for (i, j), c in sp.Poly(s, P, Q).terms()]
            for s in special
        ]
        self.coefficients = sp.lambdify((P, Q), poly.all_coeffs(), "mpmath")

    def real(self, place: tuple[Any, Any]) -> list[Any]:
        """Real roots in order."""
        found = [mp.mpf(c) for c in self.coefficients(*place)]
        while found and found[0] == 0:
            del found[0]
        roots = mp.polyroots(found, maxsteps=500, extraprec=400) if len(found) > 1 else []
        return sorted(mp.re(r) for r in roots if abs(mp.im(r)) < 1e-18 * (1 + abs(r)))

    def follow(self, start: tuple[float, float], x: float, stop: tuple[float, float]) -> Any:
        """The root to which the one nearest to x at `start` leads, or None where it ends."""
        with mp.workdps(40):
            ends = [(mp.mpf(float(a)), mp.mpf(float(b))) for a, b in zip(start, stop, strict=True)]
            inner = self._special(start, stop)
            knots = sorted({mp.mpf(0), mp.mpf(1)} | inner)
            for low, high in zip(knots[:-1], knots[1:], strict=True):
                before, after = (
                    self.real(tuple(a + t * (b - a) for a, b in ends))
                    for t in (low + NEAR, high - NEAR)
                )
                assert len(before) == len(after)
                x = after[min(range(len(before)), key=lambda i: abs(before[i] - x))]
                close = sum(abs(r - x) < TOGETHER * (1 + abs(x)) for r in after) > 1
                if high in inner and (close or abs(x) > FAR):
                    return None
            last = self.real(tuple(b for _, b in ends))
            return min(last, key=lambda r: abs(r - x), default=None)

    def _special(self, start: tuple[float, float], stop: tuple[float, float]) -> set[Any]:
        """Shares of a line in (0, 1] at which real roots may end, to 40 digits."""
        exact = [[fmpq(*float(v).as_integer_ratio()) for v in s] for s in (start, stop)]
        p, q = (fmpq_poly([a, b - a]) for a, b in zip(*exact, strict=True))
        found: list[Any] = []
        before, ctx.prec = ctx.prec, 200
        try:
            for terms in self.special:
                along = sum((c * p**i * q**j for i, j, c in terms), fmpq_poly([]))
                if along.degree() > 0:
                    roots = along.numer().complex_roots()
                    found += [r.real.mid().str(45, radius=False) for r, _ in roots if r.imag == 0]
        finally:
            ctx.prec = before
        return {r for r in map(mp.mpf, found) if 0 < r <= 1}
