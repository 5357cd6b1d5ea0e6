"""The reduced characteristic polynomial over a rectangle of two parameters, and its degeneracies.

With p(λ) = E(λ²) + λ O(λ²), where structural zeros are left out:

* double zero: the constant and the linear coefficient vanish;
* zero and a pair: the constant coefficient vanishes, and E and O of p(λ)/λ have a common root;
* two pairs: E and O have two common roots, so both coefficients of their first subresultant vanish.

Each is a pair of equations with simple solutions at a generic point.  Subresultants are minors of
the Bezout matrix.

Source: B. L. van der Waerden, Algebra I, § 34 (resultants); tests/boundary/test_codimension_two.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flint import Ordering, arb, arb_series, fmpq_mpoly_ctx

from ...algebra.exact.function_field import occurring
from ...algebra.exact.hurwitz_forms import Budget
from ...algebra.exact.number_fields import NotExact, rational
from ...algebra.exact.routh import divided, expanded_determinant, hurwitz_sign, times
from ...algebra.krawczyk import NotProvedError
from ...polynomials.characteristic import CharacteristicPolynomial
from ...spectra.problem import Problem
from ...systems.graph.family_graph import Sloped
from ...systems.structure.enclosure import ball_unknowns
from ...systems.structure.structural_zeros import structure
from ..interval_search.meetings import polynomial
from ..interval_search.taylor import linearisation, terms
from .point_records import PointKind

Poly = list[Any]
"""Coefficients, lowest power first, of any ring."""


def slope(value: Sloped) -> list[Any]:
    """Slopes of a number along x and y."""
    return [value.slopes.get(axis, arb(0)) for axis in (0, 1)]


# --- Bezout ---


def halves(p: Poly) -> tuple[Poly, Poly]:
    """E and O of a polynomial E(λ²) + λ O(λ²)."""
    return p[::2], p[1::2]


def bezout(f: Poly, g: Poly) -> list[Poly]:
    """The Bezout matrix of two polynomials, the degree of `f` not below that of `g`."""
    size = len(f) - 1
    zero = f[0] - f[0]
    g = [*g, *[zero] * (size + 1 - len(g))]
    rows = [[zero] * size for _ in range(size)]
    for i in range(size):
        for j in range(size):
            total = zero
            for k in range(max(0, i + j + 1 - size), min(i, j) + 1):
                total = total + (f[i + j + 1 - k] * g[k] - f[k] * g[i + j + 1 - k])
            rows[i][j] = total
    return rows


def subresultant(f: Poly, g: Poly, order: int) -> Poly:
    """Subresultant of an order as a polynomial, up to powers of the leading coefficient of `f`.

    Parameters
    ----------
    f, g
        Polynomials, the degree of `f` not below that of `g`.
    order
        Its degree at most; 0 for the resultant.

    Examples
    --------
    >>> subresultant([arb(2), arb(-3), arb(1)], [arb(-1), arb(1)], 1) == [arb(-1), arb(1)]
    True
    """
    size = len(f) - 1
    if order >= size:
        return list(f)
    rows = bezout(f, g)[order:]
    tail = list(range(order + 1, size))
    return [
        expanded_determinant([[row[j] for j in (i, *tail)] for row in rows])
        for i in range(order + 1)
    ]


def equations(kind: PointKind, p: Poly) -> list[Any] | None:
    """The two equations of a kind; None where the polynomial is too short for it.

    Parameters
    ----------
    kind
        Kind of point.
    p
        Coefficients, lowest first, in any ring.
    """
    degree = len(p) - 1
    if kind is PointKind.DOUBLE_ZERO:
        return [p[0], p[1]] if degree >= 2 else None
    if kind is PointKind.ZERO_HOPF:
        return [p[0], subresultant(*halves(p[1:]), 0)[0]] if degree >= 3 else None
    return subresultant(*halves(p), 1) if degree >= 4 else None


# --- what a solution is ---


@dataclass(frozen=True)
class Nature:
    """What a proved solution of the equations is."""

    frequencies: tuple[Any, ...]
    """ω of each pair, as balls, in increasing order."""
    others: int
    """1: every other eigenvalue is proved to be stable; -1: one is unstable; 0: open."""


def nature(kind: PointKind, p: Poly) -> Nature | None:
    """Pairs and other eigenvalues at a solution; None where no pair is on the imaginary axis.

    Raises
    ------
    NotProvedError
        If it is not decided, as where more eigenvalues meet.
    """
    if _sign(p[-1]) < 0:
        p = [-c for c in p]
    if kind is PointKind.DOUBLE_ZERO:
        _sign(p[2])
        return Nature((), hurwitz_sign(p[2:]))
    if kind is PointKind.ZERO_HOPF:
        d = p[1:]
        low, high = subresultant(*halves(d), 1)
        _sign(high)
        place = -low / high
        if _sign(place) > 0:
            return None
        return Nature(((-place).sqrt(),), hurwitz_sign(divided(d, [-place, arb(0), arb(1)])))
    low, middle, high = subresultant(*halves(p), 2)
    _sign(high)
    s, t = -middle / high, low / high
    spread = s * s - 4 * t
    if _sign(spread) < 0 or _sign(t) < 0 or _sign(s) > 0:
        return None
    root = spread.sqrt()
    pairs = (((-s - root) / 2).sqrt(), ((-s + root) / 2).sqrt())
    return Nature(pairs, hurwitz_sign(divided(p, [t, arb(0), -s, arb(0), arb(1)])))


def _sign(value: Any) -> int:
    if value > 0:
        return 1
    if value < 0:
        return -1
    raise NotProvedError


PLANE = fmpq_mpoly_ctx.get(("x", "y"), Ordering.lex)
"""Q[x, y] of the two axes."""
MOST_TERMS = 4000
"""Largest number of terms of a polynomial of the exact route."""
SECONDS = 20.0
"""Longest time for the polynomial of the exact route [s]."""


class GraphPlane:
    """The polynomial from the graph, in balls, at points or over boxes.

    Parameters
    ----------
    problem
        Family with a number for every quantity but the axes.
    names
        Names of x and y.
    """

    def __init__(self, problem: Problem, names: tuple[str, str]) -> None:
        self.problem, self.names, self.family = problem, names, problem.family
        self.zeros = structure(self.family).zeros
        self.fixed = {n: arb(float(v)) for n, v in problem.values.items() if n not in names}

    def at(self, x: Any, y: Any) -> list[Sloped]:
        """Coefficients with their slopes, lowest first, without structural zeros.

        Raises
        ------
        NoMemberError
            If no root of the family's equations is proved over the box.
        """
        start = self._unknowns(x, y)
        forms = []
        for series in ((arb_series([x, 1]), y), (x, arb_series([y, 1]))):
            with terms(2):
                matrices = linearisation(self.family, *self._numbers(*series), start, 2)
                forms.append(polynomial(matrices, fold=False)[self.zeros :])
        return [Sloped(c[0], {0: c[1], 1: d[1]}) for c, d in zip(*forms, strict=True)]

    @property
    def solved(self) -> tuple[int, ...]:
        """Axes in the equations of the unknowns; both where there are none or neither is."""
        family = self.family
        base = (*family.at, *family.parameters)
        names = [family.meaning(n) for n in self.names]
        used = {base[i] for i in family.graph.used} if family.unknown else set()
        axes = tuple(i for i, n in enumerate(names) if n in used)
        return axes or (0, 1)

    def _numbers(self, x: Any, y: Any) -> tuple[list[Any], list[Any]]:
        return self.problem.balls(self.fixed | dict(zip(self.names, (x, y), strict=True)))

    def _unknowns(self, x: Any, y: Any) -> list[Any]:
        family = self.family
        here = ball_unknowns(family, *self._numbers(arb(x).mid(), arb(y).mid()))
        if not family.unknown or family.closed:
            return here
        return ball_unknowns(family, *self._numbers(x, y), [float(v.mid()) for v in here])


class ExactPlane:
    """The polynomial with coefficients in Q[x, y], in axes or their sines or cosines.

    Parameters
    ----------
    coefficients
        Elements of `PLANE`, lowest power of λ first.
    turns
        For each axis sin or cos where the variable is that function of it; otherwise empty.
    """

    def __init__(self, coefficients: Sequence[Any], turns: tuple[str, str] = ("", "")) -> None:
        self.coefficients, self.turns = list(coefficients), turns
        self.polynomial: CharacteristicPolynomial | None = None
        """What the coefficients were derived from; None where they are given."""
        self.names = ("", "")
        """Names of the axes in the family."""
        self._terms = [
            tuple(_terms(p) for p in (c, c.derivative("x"), c.derivative("y")))
            for c in self.coefficients
        ]

    def ends(self, axis: int, low: float, high: float) -> tuple[Any, Any]:
        """Ends of the variable, as balls, from those of an axis.

        Raises
        ------
        NotExact
            If the function is not monotonic between them.
        """
        turn, bounds = self.turns[axis], (arb(low), arb(high))
        if not turn:
            return bounds
        quarter = arb.pi() / 2
        inside = (-quarter, quarter) if turn == "sin" else (arb(0), 2 * quarter)
        if not (inside[0] <= bounds[0] and bounds[1] <= inside[1]):
            raise NotExact(f"the {turn}e of the axis is not monotonic")
        values = [getattr(v, turn)() for v in bounds]
        return (values[0], values[1]) if turn == "sin" else (values[1], values[0])

    @property
    def alone(self) -> bool:
        """Whether every member lies on the branch of the polynomial."""
        return self.polynomial is None or self.polynomial.triangular.alone

    def holds(self, x: Any, y: Any) -> bool:
        """Whether the member at balls of the axes lies on the branch of the polynomial.

        Raises
        ------
        NoMemberError
            If no member is proved there.
        """
        if self.polynomial is None or self.alone:
            return True
        point = {**self.polynomial.values, **dict(zip(self.names, (x, y), strict=True))}
        return self.polynomial.elsewhere(self.polynomial.member(point)) is None

    def back(self, axis: int, value: Any) -> Any:
        """The axis from its variable; not finite where the ball reaches beyond 1."""
        turn = self.turns[axis]
        return getattr(value, f"a{turn}")() if turn else value

    def at(self, x: Any, y: Any) -> list[Sloped]:
        """Coefficients with their slopes at balls."""
        rows = ([_value(t, x, y) for t in row] for row in self._terms)
        return [Sloped(value, {0: by_x, 1: by_y}) for value, by_x, by_y in rows]


def _terms(p: Any) -> list[tuple[int, int, Any]]:
    return [(int(i), int(j), c) for (i, j), c in p.to_dict().items()]


def _value(some: Sequence[tuple[int, int, Any]], x: Any, y: Any) -> Any:
    powers = []
    for base, place in ((arb(x), 0), (arb(y), 1)):
        row = [arb(1)]  # by products: a ball's own power is undefined where it holds zero
        for _ in range(max((term[place] for term in some), default=0)):
            row.append(row[-1] * base)
        powers.append(row)
    return sum((powers[0][i] * powers[1][j] * c for i, j, c in some), arb(0))


def value_of(p: Any, x: Any, y: Any) -> Any:
    """A polynomial of `PLANE` at balls."""
    return _value(_terms(p), x, y)


def exact_plane(problem: Problem, names: tuple[str, str]) -> ExactPlane:
    """The polynomial over Q[x, y].

    Raises
    ------
    NotExact
        If the linearisation is not rational in both axes, or too large.
    """
    family = problem.family
    base = (*family.at, *family.parameters)
    if not (problem.plain or problem.dimensionless):
        raise NotExact("units bring square roots")
    axes = tuple(family.meaning(n) for n in names)
    numbers = {family.meaning(n): v for n, v in problem.values.items()}
    if not set(base) <= set(numbers) or not set(axes) <= set(base):
        raise NotExact("the family has other names")
    values = {n: rational(float(numbers[n])) for n in base if n not in axes}
    polynomial = CharacteristicPolynomial(family, values, Budget(MOST_TERMS, SECONDS))
    form = polynomial.factored
    zeros = form.zeros - structure(family).zeros
    if zeros < 0:
        raise NotExact("structural zeros are not proved")
    variables = Variables(polynomial, (axes[0], axes[1]))
    out = [PLANE.constant(0)] * zeros + [PLANE.constant(1)]
    for factor, count in form.factors:
        moved = [variables.moved(c) for c in factor]
        for _ in range(count):
            out = times(out, moved)
    plane = ExactPlane(out, variables.turns)
    plane.polynomial, plane.names = polynomial, (axes[0], axes[1])
    return plane


class Variables:
    """How the variables of a polynomial over Q are functions of two axes.

    Parameters
    ----------
    polynomial
        The characteristic polynomial.
    axes
        Names of x and y in the family.

    Raises
    ------
    NotExact
        If another function of an axis remains, or both an axis and its sine.
    """

    def __init__(self, polynomial: CharacteristicPolynomial, axes: tuple[str, str]) -> None:
        form = polynomial.factored
        polys = [c for factor, _ in form.factors for c in factor]
        used = {i for p in polys for i in occurring(p)}
        self._what = {i: self._named(polynomial, form.indices[i], axes) for i in used}
        forms = [{f for a, f in self._what.values() if a == axis} for axis in (0, 1)]
        turns = []
        for axis, some in enumerate(forms):
            if "" in some and len(some) > 1:
                raise NotExact("an axis and its sine occur together")
            turns.append(self._kept_function(axis, polys) if len(some) > 1 else "".join(some))
        self.turns = turns[0], turns[1]

    @staticmethod
    def _named(
        polynomial: CharacteristicPolynomial, index: int, axes: tuple[str, str]
    ) -> tuple[int, str]:
        if index < len(polynomial.base) and polynomial.base[index] in axes:
            return axes.index(polynomial.base[index]), ""
        if index not in polynomial.field.meaning:
            raise NotExact("another variable remains")
        function, x, _ = polynomial.field.meaning[index]
        for axis, name in enumerate(axes):
            variable = polynomial.field.generator(polynomial.base.index(name))
            if function in ("sin", "cos") and x.num == variable and x.den.is_constant():
                return axis, function
        raise NotExact("another function of the axes remains")

    def _kept_function(self, axis: int, polys: Sequence[Any]) -> str:
        """Sin or cos: that whose partner has even powers alone."""
        for kept, gone in (("sin", "cos"), ("cos", "sin")):
            places = [i for i, what in self._what.items() if what == (axis, gone)]
            if all(row[i] % 2 == 0 for p in polys for row in p.to_dict() for i in places):
                return kept
        raise NotExact("odd powers of sine and cosine remain")

    def moved(self, p: Any) -> Any:
        """A coefficient as an element of `PLANE`."""
        out = PLANE.constant(0)
        gens = PLANE.gens()
        for row, c in p.to_dict().items():
            term = PLANE.constant(c)
            for i, e in enumerate(row):
                if not e:
                    continue
                axis, form = self._what[i]
                same = form == self.turns[axis]
                base = gens[axis] if same else 1 - gens[axis] ** 2
                term = term * base ** (int(e) if same else int(e) // 2)
            out = out + term
        return out
