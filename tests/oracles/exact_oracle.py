"""The truth of a small linearisation by exact arithmetic; nothing here comes from the package.

A CasADi graph is read instruction by instruction with dual numbers over the rationals
(python-flint's `fmpq`), or over Arb's balls where a value is irrational.  The characteristic
polynomial gives the eigenvalues twice: by a Sturm chain on the imaginary axis (how many lie on
either side and on it), and by Arb's isolated roots (where they lie).  The two counts are compared
at each use.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import flint
import numpy as np
from flint import acb, arb, fmpq, fmpq_mat, fmpq_poly

BITS = 6000
ZERO = fmpq(0)


class Irrational(Exception):
    """A value that no rational states; balls must take over."""


class Kink(Exception):
    """A point at which the graph has no derivative."""


class Meaningless(Exception):
    """A division by zero, or a root or logarithm outside its domain."""


def exact(value: float) -> fmpq:
    """The rational that a double is."""
    return fmpq(*float(value).as_integer_ratio())


def _isqrt(value: fmpq) -> fmpq:
    if value < 0:
        raise Meaningless
    p, q = flint.fmpz(value.p), flint.fmpz(value.q)
    rp, rq = p.isqrt(), q.isqrt()
    if rp * rp != p or rq * rq != q:
        raise Irrational
    return fmpq(rp, rq)


class Rationals:
    """Exact values; what is irrational raises `Irrational`."""

    known: dict[str, tuple[fmpq, fmpq]] = {
        "exp": (fmpq(0), fmpq(1)),
        "log": (fmpq(1), fmpq(0)),
        "sin": (fmpq(0), fmpq(0)),
        "cos": (fmpq(0), fmpq(1)),
        "tan": (fmpq(0), fmpq(0)),
    }

    def number(self, value: float) -> fmpq:
        return exact(value)

    def call(self, name: str, value: fmpq) -> fmpq:
        if name == "sqrt":
            return _isqrt(value)
        at, result = self.known[name]
        if value != at:
            raise Irrational
        return result

    def sign(self, value: fmpq) -> int:
        return int(value > 0) - int(value < 0)

    def floor(self, value: fmpq) -> fmpq:
        return fmpq(value.floor())


class Balls:
    """Arb's balls; a ball that holds zero beyond `BITS` is taken for the zero that was planted."""

    def number(self, value: float) -> arb:
        return arb(exact(value))

    def call(self, name: str, value: arb) -> arb:
        result = getattr(arb(value), name)()
        if not result.is_finite():
            raise Meaningless
        return result

    def sign(self, value: Any) -> int:
        value = arb(value)
        if value > 0:
            return 1
        if value < 0:
            return -1
        assert value.rad() < arb(2) ** (-BITS // 8), "the balls are too wide"
        return 0

    def floor(self, value: Any) -> arb:
        return arb(value).floor()


class Dual:
    """A value with its derivative in each state; bent where only its Lipschitz bound is known.

    |u| at u = 0 has no derivative, and |u| v has one where v = 0 too: |u v| is of second order.
    """

    __slots__ = ("bent", "slope", "value")

    def __init__(self, value: Any, slope: Sequence[Any], bent: bool = False) -> None:
        self.value, self.slope, self.bent = value, slope, bent

    def map(self, value: Any, factor: Any) -> Dual:
        slope = [factor * s if not _nothing(s) else s for s in self.slope]
        return Dual(value, slope, self.bent and not _nothing(factor))

    @property
    def flat(self) -> bool:
        return not self.bent and all(_nothing(s) for s in self.slope)


def _nothing(value: Any) -> bool:
    return bool(value == 0)


def _add(a: Dual, b: Dual, sign: int = 1) -> Dual:
    slope = [s + sign * t for s, t in zip(a.slope, b.slope, strict=True)]
    return Dual(a.value + sign * b.value, slope, a.bent or b.bent)


def _mul(a: Dual, b: Dual) -> Dual:
    slope = [s * b.value + a.value * t for s, t in zip(a.slope, b.slope, strict=True)]
    bent = (a.bent and not _nothing(b.value)) or (b.bent and not _nothing(a.value))
    return Dual(a.value * b.value, slope, bent)


def _inverse(ring: Any, a: Dual) -> Dual:
    if ring.sign(a.value) == 0:
        raise Meaningless
    one = ring.number(1.0)
    r = one / a.value
    return a.map(r, -r * r)


def _power(ring: Any, a: Dual, b: Dual) -> Dual:
    if not b.flat:
        raise NotImplementedError
    try:
        n = int(fmpq(b.value).p) if isinstance(b.value, fmpq) else int(b.value.unique_fmpz())
    except (TypeError, ValueError) as error:
        raise NotImplementedError from error
    if isinstance(b.value, fmpq) and b.value.q != 1:
        raise NotImplementedError
    if n < 0:
        a, n = _inverse(ring, a), -n
    result = Dual(ring.number(1.0), [ZERO] * len(a.slope))
    for _ in range(n):
        result = _mul(result, a)
    return result


def _choose(ring: Any, a: Dual, b: Dual, sign: int) -> Dual:
    """The larger of two (sign = 1) or the smaller (sign = -1)."""
    side = ring.sign(a.value - b.value) * sign
    if side == 0 and not _add(a, b, -1).flat:
        return Dual(a.value, a.slope, bent=True)
    return a if side >= 0 else b


def _step(a: Dual, value: Any) -> Dual:
    return Dual(value, [ZERO] * len(a.slope))


def _unary(ring: Any, op: int, a: Dual) -> Dual:
    call = ring.call
    match op:
        case ca.OP_ASSIGN:
            return a
        case ca.OP_NEG:
            return a.map(-a.value, -1)
        case ca.OP_SQ:
            return _mul(a, a)
        case ca.OP_TWICE:
            return a.map(2 * a.value, 2)
        case ca.OP_INV:
            return _inverse(ring, a)
        case ca.OP_EXP:
            e = call("exp", a.value)
            return a.map(e, e)
        case ca.OP_SIN:
            return a.map(call("sin", a.value), call("cos", a.value))
        case ca.OP_COS:
            return a.map(call("cos", a.value), -call("sin", a.value))
        case ca.OP_TAN:
            t = call("tan", a.value)
            return a.map(t, 1 + t * t)
        case ca.OP_LOG:
            if ring.sign(a.value) <= 0:
                raise Meaningless
            return a.map(call("log", a.value), ring.number(1.0) / a.value)
        case ca.OP_SQRT:
            return _root(ring, a)
        case _:
            return _pieces(ring, op, a)


def _root(ring: Any, a: Dual) -> Dual:
    side = ring.sign(a.value)
    if side < 0:
        raise Meaningless
    if side == 0:
        if not a.flat:
            raise Kink
        return _step(a, ring.number(0.0))
    r = ring.call("sqrt", a.value)
    return a.map(r, ring.number(0.5) / r)


def _pieces(ring: Any, op: int, a: Dual) -> Dual:
    side = ring.sign(a.value)
    if op == ca.OP_NOT:
        return _step(a, ring.number(float(side == 0)))
    if op == ca.OP_FLOOR or op == ca.OP_CEIL:
        down = ring.floor(a.value)
        if ring.sign(a.value - down) == 0 and not a.flat:
            raise Kink
        return _step(a, down if op == ca.OP_FLOOR else -ring.floor(-a.value))
    if op not in (ca.OP_FABS, ca.OP_SIGN):
        raise NotImplementedError(op)
    if side == 0 and not a.flat:
        if op == ca.OP_SIGN:
            raise Kink
        return Dual(a.value, a.slope, bent=True)
    return a.map(a.value * side, side) if op == ca.OP_FABS else _step(a, ring.number(side))


def _truth(ring: Any, value: bool, a: Dual) -> Dual:
    return _step(a, ring.number(float(value)))


def _binary(ring: Any, op: int, a: Dual, b: Dual) -> Dual:
    match op:
        case ca.OP_ADD:
            return _add(a, b)
        case ca.OP_SUB:
            return _add(a, b, -1)
        case ca.OP_MUL:
            return _mul(a, b)
        case ca.OP_DIV:
            return _mul(a, _inverse(ring, b))
        case ca.OP_POW | ca.OP_CONSTPOW:
            return _power(ring, a, b)
        case ca.OP_FMIN:
            return _choose(ring, a, b, -1)
        case ca.OP_FMAX:
            return _choose(ring, a, b, 1)
        case ca.OP_IF_ELSE_ZERO:
            return b if ring.sign(a.value) else _step(a, ring.number(0.0))
        case ca.OP_AND:
            return _truth(ring, bool(ring.sign(a.value) and ring.sign(b.value)), a)
        case ca.OP_OR:
            return _truth(ring, bool(ring.sign(a.value) or ring.sign(b.value)), a)
        case ca.OP_FMOD:
            return _remainder(ring, a, b)
    side = ring.sign(a.value - b.value)
    if side == 0 and not _add(a, b, -1).flat:
        raise Kink
    found = {ca.OP_LT: side < 0, ca.OP_LE: side <= 0, ca.OP_EQ: side == 0, ca.OP_NE: side != 0}
    if op not in found:
        raise NotImplementedError(op)
    return _truth(ring, found[op], a)


def _remainder(ring: Any, a: Dual, b: Dual) -> Dual:
    """C's fmod: a - b · trunc(a / b), with the sign of a."""
    if not b.flat:
        raise NotImplementedError
    ratio = a.value / b.value
    whole = ring.floor(ratio) if ring.sign(ratio) >= 0 else -ring.floor(-ratio)
    if ring.sign(ratio - whole) == 0 and not a.flat and ring.sign(ratio):
        raise Kink
    return Dual(a.value - b.value * whole, a.slope, a.bent)


UNARY = {
    ca.OP_ASSIGN,
    ca.OP_NEG,
    ca.OP_SQ,
    ca.OP_TWICE,
    ca.OP_INV,
    ca.OP_EXP,
    ca.OP_SIN,
    ca.OP_COS,
    ca.OP_TAN,
    ca.OP_LOG,
    ca.OP_SQRT,
    ca.OP_FABS,
    ca.OP_SIGN,
    ca.OP_FLOOR,
    ca.OP_CEIL,
    ca.OP_NOT,
}


class Graph:
    """Expressions in states x and parameters p, read over any ring with derivatives in x."""

    def __init__(self, x: ca.SX, p: ca.SX, expressions: ca.SX) -> None:
        f = ca.Function("f", [x, p], [ca.densify(expressions)])
        self.size, self.width = f.sz_w(), x.numel()
        self.length = expressions.numel()
        self.steps = [
            (
                f.instruction_id(k),
                f.instruction_input(k),
                f.instruction_output(k),
                f.instruction_constant(k) if f.instruction_id(k) == ca.OP_CONST else 0.0,
            )
            for k in range(f.n_instructions())
        ]

    def __call__(self, ring: Any, x: Sequence[Any], p: Sequence[Any]) -> list[Dual]:
        n = self.width
        nothing: list[Any] = [ZERO] * n
        work: list[Any] = [None] * self.size
        out: list[Any] = [Dual(ZERO, nothing)] * self.length
        for op, inputs, outputs, constant in self.steps:
            if op == ca.OP_OUTPUT:
                out[outputs[1]] = work[inputs[0]]
            elif op == ca.OP_CONST:
                work[outputs[0]] = Dual(ring.number(constant), nothing)
            elif op == ca.OP_INPUT:
                which, i = inputs
                slope = [fmpq(int(j == i and which == 0)) for j in range(n)]
                work[outputs[0]] = Dual((x, p)[which][i], slope)
            elif op in UNARY:
                work[outputs[0]] = _unary(ring, op, work[inputs[0]])
            else:
                work[outputs[0]] = _binary(ring, op, work[inputs[0]], work[inputs[1]])
        return out


def sloped(out: list[Dual]) -> list[Dual]:
    """Values that all have a derivative."""
    if any(d.bent for d in out):
        raise Kink
    return out


# --- polynomials ------------------------------------------------------------------------------


def strip(poly: fmpq_poly) -> tuple[fmpq_poly, int]:
    """A polynomial without its roots at zero, and how many there were."""
    c = poly.coeffs()
    m = next(i for i, v in enumerate(c) if v != 0)
    return fmpq_poly(c[m:]), m


def _changes(signs: Sequence[int]) -> int:
    kept = [s for s in signs if s]
    return sum(a != b for a, b in zip(kept, kept[1:], strict=False))


def _chain(a: fmpq_poly, b: fmpq_poly) -> int:
    """V(-∞) - V(+∞) of the Sturm chain that starts with a, b: the Cauchy index of b/a."""
    left, right = [], []
    while b != 0 or a != 0:
        lead = a.coeffs()[-1]
        s = 1 if lead > 0 else -1
        right.append(s)
        left.append(s if a.degree() % 2 == 0 else -s)
        if b == 0:
            break
        a, b = b, -(a % b)
    return _changes(left) - _changes(right)


def real_roots(poly: fmpq_poly) -> int:
    """How many real roots a polynomial has, each as often as it counts, by Sturm."""
    total = 0
    while poly.degree() > 0:
        total += _chain(poly, poly.derivative())
        poly = poly.gcd(poly.derivative())
    return total


def sides(poly: fmpq_poly) -> tuple[int, int, int]:
    """Roots left of, on and right of the imaginary axis; a Sturm chain along it, none at zero."""
    c = poly.coeffs()
    re = fmpq_poly([v * (1, 0, -1, 0)[i % 4] for i, v in enumerate(c)])
    im = fmpq_poly([v * (0, 1, 0, -1)[i % 4] for i, v in enumerate(c)])
    g = re.gcd(im)
    on = real_roots(g)
    mirrored = (g.degree() - on) // 2
    re, im = re // g, im // g
    d = max(re.degree(), im.degree())
    turned = -_chain(re, im) if d % 2 == 0 else _chain(im, re)
    return mirrored + (d + turned) // 2, on, mirrored + (d - turned) // 2


@dataclass(frozen=True)
class Root:
    """One eigenvalue: an enclosure, and the proved sign of its real part."""

    value: acb
    side: int


def isolated(poly: fmpq_poly) -> list[Root]:
    """Roots by Arb, refined until as many are off the imaginary axis as Sturm's chain says."""
    count = sides(poly)
    before = flint.ctx.prec
    try:
        for bits in (256, 1024, 4096, 16384, 65536):
            flint.ctx.prec = bits
            found = [
                Root(acb(value), int(value.real > 0) - int(value.real < 0))
                for value, times in poly.numer().complex_roots()
                for _ in range(times)
            ]
            tally = tuple(sum(r.side == s for r in found) for s in (-1, 0, 1))
            if tally[1] <= count[1]:
                assert tally == count, (tally, count)
                return found
    finally:
        flint.ctx.prec = before
    raise AssertionError("the roots cannot be told from the imaginary axis")


@dataclass
class Truth:
    """The spectrum at one member: roots that are not zero, how many are, and in a Jordan block."""

    roots: list[Root]
    zeros: int
    note: str = ""
    steady: bool = True
    generic: int | None = None
    member: list[float] = field(default_factory=list)
    drifts: bool = False

    def count(self, side: int) -> int:
        return sum(r.side == side for r in self.roots)

    def verdict(self, dropped: int) -> str:
        """What must be said where `dropped` zeros are left out of the spectrum."""
        if self.count(1):
            return "unstable"
        if self.count(0) or self.zeros > dropped:
            return "neutral"
        return "drifting" if self.drifts else "stable"

    def all(self, dropped: int) -> list[acb]:
        return [r.value for r in self.roots] + [acb(0)] * (self.zeros - dropped)


def spectrum_of(rows: Sequence[Sequence[fmpq]]) -> tuple[list[Root], int]:
    """Eigenvalues of a rational matrix."""
    poly, zeros = strip(fmpq_mat([list(r) for r in rows]).charpoly())
    return (isolated(poly) if poly.degree() > 0 else []), zeros


def nullity(rows: Sequence[Sequence[Any]], ring: Any) -> int:
    """Dimension of the kernel of a square matrix, by elimination."""
    left, rank = [list(row) for row in rows], 0
    for column in range(len(left)):
        at = next((i for i in range(rank, len(left)) if ring.sign(left[i][column])), None)
        if at is None:
            continue
        left[rank], left[at] = left[at], left[rank]
        for i in range(rank + 1, len(left)):
            factor = left[i][column] / left[rank][column]
            left[i] = [a - factor * b for a, b in zip(left[i], left[rank], strict=True)]
            left[i][column] = ring.number(0.0)
        rank += 1
    return len(left) - rank


def at_bits(bits: int, ask: Callable[[], Any]) -> Any:
    before = flint.ctx.prec
    flint.ctx.prec = bits
    try:
        return ask()
    finally:
        flint.ctx.prec = before


def middle(value: Any) -> float:
    return float(arb(value).mid())


def finite(value: Any) -> bool:
    return bool(np.all(np.isfinite(np.asarray(value))))
