"""The variables of a family along an axis: one base variable, and others with polynomial relations.

The base variable z is the axis itself, or the cosine (hyperbolic cosine, exponential) of a multiple
of the axis.  One transcendental constant, such as the cosine of a given angle, may be another
variable s: no polynomial over Q vanishes at it (Lindemann), so that it counts as free.  Each
further variable obeys a polynomial in the variables before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from math import gcd
from typing import Any

from flint import arb, fmpq, fmpq_mpoly_ctx

from ...algebra.exact.function_field import SPARE, Expression, occurring
from ...algebra.exact.hurwitz_forms import Budget, by_power
from ...algebra.exact.number_fields import NotExact
from ...algebra.exact.roots import UnclearError
from ...algebra.number_types import precision
from ...base.errors import StabilityError
from ...polynomials.characteristic import CharacteristicPolynomial
from ...systems.structure.structural_zeros import SAMPLE_BITS, SAMPLES
from ..brackets import AxisScan

MOST_TURNS = 12
"""Largest multiple of an angle that is written as a polynomial in its cosine."""
SHARES = (0.2718, 0.5772, 0.8541, 0.1202, 0.4142, 0.7321, 0.9159, 0.0331, 0.3606, 0.6458)
"""Shares of the interval at which members are sought that show the branch."""
KINDS = {"sin": "circle", "cos": "circle", "sinh": "hyperbola", "cosh": "hyperbola", "exp": "exp"}
"""Kind of a function of the axis, or of a number."""
BOUNDS: dict[str, tuple[int, ...]] = {
    "plain": (),
    "positive": (0,),
    "exp": (0,),
    "hyperbola": (1,),
    "circle": (-1, 1),
    "theta": (0, 1),
    "lean": (0, 1),
}
"""Values of the base variable at which the axis has an end or turns round."""
TURNED = {"theta": "sin", "lean": "cos"}
"""The base variable as a function of an inclination of the disk."""


class AxisPolynomial(CharacteristicPolynomial):
    """A family's characteristic polynomial along an axis, every other quantity a rational."""

    constants = True

    def __init__(
        self,
        line: AxisScan,
        ends: tuple[float | None, float | None],
        budget: Budget,
        spare: int = SPARE,
    ) -> None:
        problem, self.axis, self.ends = line.problem, line.axis, ends
        fixed = problem.rationals(line.fixed)
        if not problem.plain and problem.family.unknown and not problem.family.closed:
            raise NotExact("no closed form")
        super().__init__(
            problem.family,
            fixed,
            budget,
            free=(self.axis,),
            numbers=lambda v: problem.reduce(v, lambda x: x.sqrt())[:2],
            spare=spare,
        )
        self._exclude_denominators()

    @property
    def rational(self) -> bool:
        """Whether the axis alone occurs, in no function."""
        return len(self.base) == 1 and not self.field.meaning

    def _vanishing_with(self, name: str) -> Expression:
        """An expression that vanishes wherever an unknown does: itself, or its sine."""
        index = self.base.index(name)
        if index in self.triangular.solved or index in dict(self.triangular.kept):
            return self.field.symbols[index]
        sine = (
            i
            for i, (function, x, _) in self.field.meaning.items()
            if function == "sin" and x == self.field.symbols[index]
        )
        place = next(sine, None)
        if place is None:
            raise NotExact(f"{name} obeys no polynomial equation")
        return Expression(self.field, self.field.generator(place), self.field.one)

    def _exclude_denominators(self) -> None:
        """Denominators of the equations, at whose zeros the equations have no meaning."""
        triangular = self.triangular
        for equation in self.equations:
            below = Expression(self.field, equation.den, self.field.one)
            below = triangular.value(below).num
            if not below.is_constant():
                triangular.nonzero.append(self.field.reduced(below))

    @property
    def conditions(self) -> list[tuple[Expression, str]]:
        """None: the system's conditions are proved along the axis in balls."""
        return []

    def _positive(self) -> list[tuple[Expression, str]]:
        positive = () if self.family.closed else self.family.positive
        return [(self._vanishing_with(name), name) for name in positive]

    @cached_property
    def samples(self) -> list[dict[int, Any]]:
        """Values of every indeterminate at members inside the interval, as balls."""
        low, high = self.ends
        if low is None or high is None:
            raise NotExact("an axis without end")
        out: list[dict[int, Any]] = []
        with precision(SAMPLE_BITS):
            for share in SHARES:
                try:
                    values = self.at(arb(low + share * (high - low)))
                except (StabilityError, ZeroDivisionError):
                    continue
                if all(v.is_finite() for v in values.values()):
                    out.append(values)
                if len(out) == SAMPLES:
                    return out
        raise NotExact("members were not found at enough values of the axis")

    def at(self, value: Any) -> dict[int, Any]:
        """Values of every indeterminate at a value of the axis, a ball.

        Raises
        ------
        NoMemberError
            If no root of the equations is proved there.
        """
        return self.member({**self.values, self.axis: value})


@dataclass(frozen=True)
class Base:
    """Functions of multiples of one angle g·x + shift, as polynomials in one or two variables."""

    kind: str
    """plain (the axis itself), positive (the same, if it is so), circle, hyperbola or exp; of the
    disk theta (z = sin x) or lean (z = cos x), up to the upright position."""
    step: Any = 1
    """g, a rational."""
    shift: Any = 0
    """Shift of the angle, a rational."""

    def back(self, z: Any, low: Any, high: Any) -> list[Any]:
        """Values of the axis from `low` to `high` at which the base variable has a value.

        Parameters
        ----------
        z
            Value of the base variable, a ball.
        low, high
            Ends, balls; values that may lie inside count.
        """
        if any(z.contains(b) and z != b for b in BOUNDS[self.kind]):
            raise UnclearError
        if self.kind == "plain":
            values = [z]
        elif self.kind == "positive":
            values = [z] if z > 0 else []
        elif self.kind in TURNED:
            values = _upright(self.kind, z) if 0 < z <= 1 else []
        elif self.kind == "exp":
            values = [self._angle(z.log())] if z > 0 else []
        elif self.kind == "hyperbola":
            values = [self._angle(a) for a in _both(z, z.acosh())] if z >= 1 else []
        else:
            values = self._turns(z, low, high) if abs(z) <= 1 else []
        return [x for x in values if not (x < low or x > high)]

    @property
    def turned(self) -> bool:
        """Whether the variable is the sine or cosine of an inclination of the disk."""
        return self.kind in TURNED

    @property
    def domain(self) -> tuple[Any, Any]:
        """Ends of the axis by its meaning, as balls, or None."""
        if self.kind == "positive":
            return arb(0), None
        quarter = arb.pi() / 2
        return {"theta": (arb(0), 2 * quarter), "lean": (-quarter, quarter)}.get(
            self.kind, (None, None)
        )

    def variable(self, x: Any) -> Any:
        """The base variable at a value of the axis, for those that have no step."""
        function = TURNED.get(self.kind)
        return getattr(x, function)() if function else x

    def _angle(self, angle: Any) -> Any:
        return (angle - arb(self.shift)) / arb(self.step)

    def _turns(self, z: Any, low: Any, high: Any) -> list[Any]:
        base = z.acos()
        ends = [(x * self.step + self.shift) / (2 * arb.pi()) for x in (low, high)]
        first, last = (int(e.mid().floor().fmpq().p) for e in ends)
        whole = arb.pi() if z == -1 else None  # π and -π are the same angle
        return [
            self._angle(angle + 2 * turn * arb.pi())
            for turn in range(first - 1, last + 2)
            for angle in ([whole] if whole is not None else _both(z, base))
        ]


def _upright(kind: str, z: Any) -> list[Any]:
    """Both inclinations, or both leans, of a height."""
    if kind == "lean":
        return [arb(0)] if z == 1 else [-z.acos(), z.acos()]
    return [arb.pi() / 2] if z == 1 else [z.asin(), arb.pi() - z.asin()]


def _both(z: Any, angle: Any) -> list[Any]:
    return [arb(0)] if z == 1 else [angle, -angle]


def base_of(entries: Sequence[tuple[str, Any, Any]]) -> Base:
    """The one angle of which all arguments are multiples.

    Parameters
    ----------
    entries
        (function, factor, shift) of each argument, factor·x + shift.

    Raises
    ------
    NotExact
        If there is none.
    """
    kinds = {KINDS.get(name, name) for name, _, _ in entries}
    if len(kinds) > 1 or not kinds <= set(KINDS.values()):
        raise NotExact(f"functions of several kinds meet: {', '.join(sorted(kinds))}")
    if len({b / a for _, a, b in entries}) > 1:
        raise NotExact("angles with different shifts meet")
    step = reduce(_common, [abs(a) for _, a, _ in entries])
    if kinds == {"exp"} and len({a > 0 for _, a, _ in entries}) > 1:
        raise NotExact("exponentials of both signs meet")
    if entries[0][1] < 0:
        step = -step
    if max(abs(a / step) for _, a, _ in entries) > MOST_TURNS:
        raise NotExact("an angle is a high multiple of another")
    return Base(kinds.pop(), step, step * entries[0][2] / entries[0][1])


def _common(a: Any, b: Any) -> Any:
    p, q = int(a.p) * int(b.q), int(b.p) * int(a.q)
    return fmpq(gcd(p, q), int(a.q) * int(b.q))


def turned(kind: str, function: str, count: int, z: Any, other: Any) -> Any:
    """A function of a multiple of the angle, as a polynomial.

    Parameters
    ----------
    kind
        Kind of the base variable.
    function
        sin, cos, sinh, cosh or exp.
    count
        The multiple.
    z, other
        Cosine and sine of the angle itself; or the exponential.

    Examples
    --------
    >>> from flint import fmpz_poly
    >>> turned("circle", "cos", 2, fmpz_poly([0, 1]), None)
    2*x^2 + (-1)
    """
    if kind == "exp":
        return z**count
    before, here = (z**0, z) if function in ("cos", "cosh") else (z - z, other * z**0)
    for _ in range(count - 1):  # f(n + 1) = 2 z f(n) - f(n - 1) holds for all four
        before, here = here, 2 * z * here - before
    return here


@dataclass(frozen=True)
class Level:
    """A variable with its relation."""

    index: int
    """Index in the ring of the tower."""
    relation: Any
    """Polynomial in this and earlier variables that vanishes."""
    place: int
    """Index in the ring of the family's polynomials; -1 for the sine next to a cosine."""
    equation: Any
    """The relation in that ring; None for such a sine."""


class Tower:
    """Every variable of a family along an axis, in the ring Q[z, s, …, w].

    Raises
    ------
    NotExact
        If the variables do not form a tower.
    """

    def __init__(self, polynomial: AxisPolynomial) -> None:
        self.polynomial, self.whole = polynomial, polynomial.factored
        count = len(self.whole.indices)
        names = ("z", "s", *(f"v{i}" for i in range(count + 2)), "w")
        self.ring = fmpq_mpoly_ctx.get(names, "lex")
        gens = self.ring.gens()
        self._images = [*gens[2 : 2 + count], self.ring.constant(0)]
        self._extra = gens[2 + count], gens[3 + count]
        self._built: set[int] = set()
        extra: list[Level] = []
        self.base = self._clocked(self._functions(free=True), gens[0], 0, extra)
        self.fixed = self._clocked(self._functions(free=False), gens[1], 1, extra)
        self._number = next((i for i in self._built if not self._free(i)), None)
        self.levels = self._ordered(extra)
        """The variables, in the order of their elimination."""

    # --- functions ---

    def _free(self, place: int) -> bool:
        index = self.whole.indices[place]
        return self.polynomial.base.index(self.polynomial.axis) in self.polynomial.field.uses(index)

    def _functions(self, *, free: bool) -> list[tuple[int, str, Any, Any]]:
        """(index in the polynomials' ring, function, factor, shift) of each function."""
        axis = self.polynomial.base.index(self.polynomial.axis)
        out = []
        for place, index in enumerate(self.whole.indices):
            if index not in self.polynomial.field.meaning:
                continue
            name, x, _ = self.polynomial.field.meaning[index]
            if name == "sqrt":
                continue
            inside = occurring(x.num) | occurring(x.den)
            if inside != ({axis} if free else set()):
                continue
            parts = by_power(x.num, axis) if x.num != 0 else {}
            if inside & occurring(x.den) or max(parts, default=0) > 1:
                raise NotExact(f"the argument of {name} is not linear in the axis")
            below = x.den.leading_coefficient()
            numbers = [
                parts[i].leading_coefficient() / below if i in parts else fmpq(0) for i in (0, 1)
            ]
            out.append(
                (place, name, numbers[1], numbers[0])
                if free
                else (place, name, numbers[0], fmpq(0))
            )
        return out

    def _clocked(
        self, functions: list[tuple[int, str, Any, Any]], z: Any, which: int, extra: list[Level]
    ) -> Base:
        """Images of some functions as polynomials in z and a sine."""
        axis = self.polynomial.base.index(self.polynomial.axis)
        plain = [i for i, index in enumerate(self.whole.indices) if index == axis and not which]
        if plain and functions:
            raise NotExact(f"{self.polynomial.axis} and {functions[0][1]} of it both occur")
        if not functions:
            for place in plain:
                self._images[place] = z
                self._built.add(place)
            return Base("plain")
        base = base_of([entry[1:] for entry in functions])
        other = self._extra[which]
        for place, name, factor, _ in functions:
            image = turned(base.kind, name, int(abs(factor / base.step).p), z, other)
            odd = name in ("sin", "sinh") and factor / base.step < 0
            self._images[place] = -image if odd else image
            self._built.add(place)
        if base.kind != "exp":
            sign = 1 if base.kind == "circle" else -1
            relation = other**2 - sign * (1 - z**2)
            extra.append(Level(self._index(other), relation, -1, None))
        return base

    def _index(self, generator: Any) -> int:
        return next(i for i, d in enumerate(generator.degrees()) if d)

    # --- relations ---

    def image(self, poly: Any) -> Any:
        """A polynomial of the family in the ring of the tower."""
        return poly.compose(*self._images, ctx=self.ring)

    def _ordered(self, extra: list[Level]) -> tuple[Level, ...]:
        levels = list(extra)
        for place, relation in self.whole.relations:
            if place not in self._built:
                index = self._index(self._images[place])
                levels.append(Level(index, self.image(relation), place, relation))
        algebraic = {0, 1} | {level.index for level in levels}
        for place, image in enumerate(self._images[:-1]):
            if not occurring(image) <= algebraic:
                raise NotExact(f"{self.whole.names[place]} obeys no polynomial equation")
        if len({level.index for level in levels}) < len(levels):
            raise NotExact("a variable has two equations")
        out: list[Level] = []
        while levels:
            last = next(
                (
                    unused
                    for unused in levels
                    if not any(
                        unused.index in occurring(other.relation)
                        for other in levels
                        if other is not unused
                    )
                ),
                None,
            )
            if last is None:
                raise NotExact("the equations of the unknowns are not in triangular form")
            levels.remove(last)
            out.append(last)
        return tuple(out)

    def number(self) -> Any:
        """Ball of the constant s at the working precision."""
        angle = arb(self.fixed.step)
        return {"circle": angle.cos, "hyperbola": angle.cosh, "exp": angle.exp}[self.fixed.kind]()
