"""First Lyapunov coefficient of a crossing pair, or its normal form on a line of steady motions.

With A q = i ω q, |q| = 1, w A = i ω w, w q = 1, and B, C the second and third derivatives,

    l1 = Re [w C(q, q, q̄) - 2 w B(q, A⁻¹ B(q, q̄)) + w B(q̄, (2 i ω - A)⁻¹ B(q, q))] / (2 ω).

The pair is proved first: member, frequency and mode solve one system of equations, which is regular
where the pair is simple and crosses with speed, also where other eigenvalues vanish by structure.
No number of the graph is rounded: CasADi differentiates a graph whose numbers are symbols, which
become the exact doubles at the end.

Source: Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, § 5.4 (projection on the critical
eigenspace); B. Fiedler, S. Liebscher & J. C. Alexander, J. Differential Equations 167 (2000) 16-35,
for lines; tests/boundary/test_hopf_any.py compares with normal forms in closed form.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

import casadi as ca
import numpy as np
from flint import acb, acb_mat, arb, arb_mat

from ..algebra.exact.routh import divided, hurwitz_sign
from ..algebra.krawczyk import NotProvedError, Values, polished, proved
from ..algebra.number_types import balls, precision
from ..algebra.program import Program
from ..algebra.upright import Upright
from ..base.errors import ParameterError, StabilityError
from ..base.types import Floats
from ..systems.equations import Equations
from ..systems.family import Family
from ..systems.graph.constants import Constants, exact_numbers
from ..systems.structure.linearity import kept

Balls = list[Any]
GUESS_BITS = 64
"""Precision of the eigenvalues from which a search starts."""
REAL = 1e-12
"""Frequency, over the largest eigenvalue, up to which one of these counts as real."""


class DerivativePrograms:
    """Programs of a system, with inputs x and p and then directions in the state."""

    def __init__(self, system: Equations) -> None:
        system.refuse_algebraic("a Lyapunov coefficient")
        self.system = system
        constants = Constants()
        entries = [ca.vertsplit(s) if s.numel() else [] for s in (system.x, system.p)]
        bare = Program(ca.Function("rates", [system.x, system.p], [ca.densify(system.rhs)]))
        rates = ca.vertcat(*bare.run(constants.algebra(), entries)[0])
        n = len(system.states)
        u, v, w = (ca.SX.sym(name, n) for name in "uvw")
        slopes = ca.jacobian(rates, system.x)
        once = ca.jtimes(rates, system.x, u)
        twice = ca.jtimes(once, system.x, v)
        thrice = ca.jtimes(twice, system.x, w)
        numbers = constants.column

        def program(name: str, directions: list[Any], *outputs: Any) -> Program:
            dense = [ca.densify(o) for o in outputs]
            if not exact_numbers(*dense):
                raise StabilityError(
                    f"{system.name}: a number of its derivatives is not exact in double precision; "
                    "write powers with whole or half exponents."
                )
            inputs = [system.x, system.p, *directions, numbers]
            return Program(ca.Function(name, inputs, dense), constants.values)

        self.first = program("first", [], rates, slopes, ca.jacobian(rates, system.p))
        self.second = program("second", [u, v], twice)
        self.third = program("third", [u, v, w], thrice)
        mixed = ca.jacobian(once, system.p)
        self.mixed = program("mixed", [u], mixed)
        self.rates, self.column, self.values = rates, numbers, constants.values
        """The rates, with symbols for the numbers of the graph, and the values of these."""
        self.kept = kept(slopes)
        """States that others depend on: the rest follow them, and are left out."""


@lru_cache(maxsize=16)
def derivatives(system: Equations) -> DerivativePrograms:
    """The derivatives of a system, built once."""
    return DerivativePrograms(system)


class OneParameterFamily:
    """A family with one number free, at a member, in terms of the system's states and parameters.

    Parameters
    ----------
    family
        A family of a user's system.
    axis
        The free quantity: a state or parameter in `at`, or another parameter.
    fixed
        Value of every other quantity, doubles or balls.
    """

    def __init__(self, family: Family, axis: str, fixed: dict[str, Any]) -> None:
        self.family, self.axis, self.fixed = family, axis, fixed
        system = family.judged
        for name in family.equations:
            if name not in system.states:
                raise ParameterError(
                    f"{family.name} is solved for by {name} = 0, an observable; what happens "
                    "beyond the linearisation is found only where rates of states are solved."
                )
        self.d = derivatives(system)
        self.solved = () if family.closed else tuple(family.unknown)
        self.rows = [] if family.closed else [system.index(n) for n in family.equations]

    def point(self, value: Any, unknowns: Sequence[Any]) -> tuple[Balls, Balls]:
        """States and parameters as balls.

        Parameters
        ----------
        value
            Value of the axis.
        unknowns
            The unknowns; not read where the family's guess solves its equations.
        """
        family, system = self.family, self.family.system
        table: dict[str, Any] = {n: arb(v) for n, v in self.fixed.items()}
        table[self.axis] = arb(value)
        for name, held in family.fixed.items():
            table[name] = arb.pi() / 2 if isinstance(held, Upright) else arb(held)
        values = list(family.unknown.values()) if family.closed else list(unknowns)
        table |= {n: arb(v) for n, v in zip(family.unknown, values, strict=True)}
        return [table[n] for n in system.states], [table[n] for n in system.parameters]

    def row(self, value: float) -> tuple[Floats, Floats, Floats]:
        """Family parameters, unknowns and parameters of a member in double precision, one row."""
        family = self.family
        values = {n: float(arb(v).mid()) for n, v in self.fixed.items()} | {self.axis: value}
        a = np.array([[values[n] for n in family.at]])
        q = np.array([[values[n] for n in family.parameters]]).reshape(1, -1)
        return a, family.solve(a, q), q

    def member(self, value: float) -> list[float]:
        """The unknowns of the family's member, in double precision; none where they are known."""
        return [float(v) for v in self.row(value)[1][0]] if self.solved else []

    @property
    def free(self) -> tuple[str, ...]:
        """The axis, and what is solved for: states and parameters."""
        return (self.axis, *self.solved)

    def first(self, x: Balls, p: Balls) -> tuple[Balls, list[Balls], list[Balls]]:
        """Rates, Jacobian, and slopes of the rates by what is free, one column each."""
        n = len(x)
        rates, slopes, by_p = self.d.first.run(balls(), [x, p])
        rows = [[arb(slopes[j * n + i]) for j in range(n)] for i in range(n)]
        columns = self._by_free(lambda j: [row[j] for row in rows], lambda: by_p, n)
        return [arb(r) for r in rates], rows, [[arb(v) for v in c] for c in columns]

    def turned(self, x: Balls, p: Balls, v: Balls) -> list[Balls]:
        """Slopes of A v by what is free."""
        mixed = cache(lambda: self.d.mixed.run(balls(), [x, p, v])[0])
        return self._by_free(lambda j: self.second(x, p, v, self.unit(j)), mixed, len(x))

    def _by_free(
        self, by_state: Callable[[int], Balls], by_parameters: Callable[[], Balls], n: int
    ) -> list[Balls]:
        """Columns of what is free: of a state by its index, of a parameter from all columns."""
        system, out = self.family.system, []
        for name in self.free:
            if name in system.states:
                out.append(by_state(system.index(name)))
            else:
                place = n * system.parameters.index(name)
                out.append(by_parameters()[place : place + n])
        return out

    def second(self, x: Balls, p: Balls, u: Balls, v: Balls) -> Balls:
        """B(u, v), the second derivative."""
        return self.d.second.run(balls(), [x, p, u, v])[0]

    def third(self, x: Balls, p: Balls, u: Balls, v: Balls, w: Balls) -> Balls:
        """C(u, v, w), the third derivative."""
        return self.d.third.run(balls(), [x, p, u, v, w])[0]

    def whole(self, part: Sequence[Any]) -> Balls:
        """A vector over the kept states as one over all."""
        out = [arb(0)] * len(self.family.system.states)
        for i, v in zip(self.d.kept, part, strict=True):
            out[i] = v
        return out

    def unit(self, index: int) -> Balls:
        """Direction of one state."""
        return [arb(int(i == index)) for i in range(len(self.family.system.states))]


@dataclass(frozen=True)
class Pair:
    """A crossing pair, in balls."""

    equations: PairEquations
    """Its equations, and so its phase."""
    value: Any
    """Value of the axis."""
    unknowns: Balls
    """The member's unknowns."""
    frequency: Any
    """ω."""
    mode: Balls
    """Eigenvector over the kept states, complex, of unit length."""
    box: Balls
    """All unknowns of the equations, to start a search nearby."""

    @property
    def line(self) -> OneParameterFamily:
        """The line along which it crosses."""
        return self.equations.line

    @property
    def point(self) -> tuple[Balls, Balls]:
        """States and parameters."""
        return self.line.point(self.value, self.unknowns)

    @property
    def matrix(self) -> Any:
        """Linearisation over the kept states."""
        kept = self.line.d.kept
        _, slopes, _ = self.line.first(*self.point)
        return arb_mat([[slopes[i][j] for j in kept] for i in kept])


class PairEquations:
    """The equations of a pair: unknowns are the axis, the member's unknowns, Re v, Im v and ω.

    Parameters
    ----------
    line
        The line.
    phase
        c of the condition c* v = 1, complex doubles over the kept states.
    """

    def __init__(self, line: OneParameterFamily, phase: Any) -> None:
        self.line = line
        self.phase = [(arb(float(c.real)), arb(float(c.imag))) for c in phase]
        self.count = len(line.solved)

    def on(self, line: OneParameterFamily) -> PairEquations:
        """The same on another line, with the same phase."""
        return PairEquations(line, [complex(float(a), float(b)) for a, b in self.phase])

    def cut(self, z: Values) -> tuple[Any, Values, Values, Values, Any]:
        """The unknowns in parts."""
        m, n = self.count, len(self.line.d.kept)
        return z[0], z[1 : 1 + m], z[1 + m : 1 + m + n], z[1 + m + n : 1 + m + 2 * n], z[-1]

    def __call__(self, z: Values) -> tuple[Values, list[Values]]:
        """Values and rows of slopes of the equations."""
        line, kept = self.line, self.line.d.kept
        value, unknowns, vr, vi, w = self.cut(z)
        x, p = line.point(value, unknowns)
        rates, slopes, columns = line.first(x, p)
        n, m, size = len(kept), self.count, len(z)
        values: Values = []
        rows: list[Values] = []
        for i in line.rows:
            values.append(rates[i])
            rows.append([column[i] for column in columns] + [arb(0)] * (2 * n + 1))
        for part, other, sign, start in ((vr, vi, 1, 0), (vi, vr, -1, n)):
            full = line.whole(part)
            turns = line.turned(x, p, full)
            for k, i in enumerate(kept):
                total = sum((slopes[i][j] * v for j, v in zip(kept, part, strict=True)), arb(0))
                values.append(total + sign * w * other[k])
                row = [arb(0)] * size
                row[: 1 + m] = [arb(t[i]) for t in turns]
                for c, j in enumerate(kept):
                    row[1 + m + start + c] = slopes[i][j]
                row[1 + m + n - start + k] += sign * w
                row[-1] = sign * other[k]
                rows.append(row)
        phase = self.phase
        triples = list(zip(phase, vr, vi, strict=True))
        values.append(sum((a * r + b * s for (a, b), r, s in triples), arb(-1)))
        values.append(sum((a * s - b * r for (a, b), r, s in triples), arb(0)))
        empty = [arb(0)] * (1 + m)
        rows.append([*empty, *[a for a, _ in phase], *[b for _, b in phase], arb(0)])
        rows.append([*empty, *[-b for _, b in phase], *[a for a, _ in phase], arb(0)])
        return values, rows


def guess(
    line: OneParameterFamily, value: float, frequency: float | None = None
) -> tuple[PairEquations, list[float]]:
    """Equations of a pair and a first guess in double precision.

    Parameters
    ----------
    line
        The line.
    value, frequency
        Approximate value of the axis and |Im λ|; the pair nearest to the imaginary axis when left
        out.

    Raises
    ------
    NotProvedError
        If there is none.
    """
    a, u, q = line.row(value)
    kept = line.d.kept
    matrix = line.family.matrix(a, u, q)[0][np.ix_(kept, kept)]
    if not np.isfinite(matrix).all():
        raise NotProvedError
    with precision(GUESS_BITS):
        eigenvalues, columns = acb_mat(matrix.tolist()).eig(right=True, algorithm="approx")
    values = np.array([complex(v) for v in eigenvalues])
    if frequency is None:
        turns = values.imag > REAL * np.abs(values).max()
        far = np.where(turns, np.abs(values.real), np.inf)
    else:
        far = np.abs(values - 1j * frequency)
    best = int(np.argmin(far))
    if not np.isfinite(far[best]):
        raise NotProvedError
    mode = np.array([complex(columns[i, best]) for i in range(len(values))])
    mode /= np.linalg.norm(mode)
    unknowns = map(float, u[0]) if line.solved else ()
    return PairEquations(line, mode), [
        value,
        *unknowns,
        *map(float, mode.real),
        *map(float, mode.imag),
        float(values[best].imag),
    ]


def pair_near(line: OneParameterFamily, value: float, frequency: float | None = None) -> Pair:
    """The crossing pair near a value of the axis, proved at the working precision.

    Raises
    ------
    NotProvedError
        If the test fails: the pair is not simple, does not cross with speed, or is not there.
    """
    return solved_pair(*guess(line, value, frequency))


def solved_pair(equations: PairEquations, start: Sequence[Any]) -> Pair:
    """The pair that Newton's method reaches from numbers nearby, proved."""
    rough = polished(equations, [float(arb(v).mid()) for v in start])
    return pair_of(equations, proved(equations, rough))


def pair_of(equations: PairEquations, box: Values) -> Pair:
    """A pair from a proved solution of its equations, with the mode scaled to unit length."""
    value, unknowns, vr, vi, w = equations.cut(box)
    if not w > 0:
        raise NotProvedError
    mode = [acb(r, s) for r, s in zip(vr, vi, strict=True)]
    length = sum((r * r + s * s for r, s in zip(vr, vi, strict=True)), arb(0)).sqrt()
    mode = [v / length for v in mode]
    return Pair(equations, value, unknowns, w, mode, box)


# --- linear algebra next to an eigenvalue ---


def bordered(matrix: Any, right: Balls) -> Balls:
    """The left null vector of a singular matrix, scaled so that its product with `right` is 1.

    Parameters
    ----------
    matrix
        Complex matrix whose kernel is spanned by `right`.
    right
        Null vector.

    Raises
    ------
    NotProvedError
        If the kernel is not proved to be one-dimensional, or the eigenvalue to be simple.
    """
    n = len(right)
    table = np.array(
        [
            [complex(matrix[i, j].real.mid(), matrix[i, j].imag.mid()) for j in range(n)]
            for i in range(n)
        ]
    )
    if not np.isfinite(table).all():
        raise NotProvedError
    # a numeric left null vector is outside the range
    column = [acb(float(c.real), float(c.imag)) for c in np.linalg.svd(table)[0][:, -1]]
    rows = [[matrix[j, i] for j in range(n)] + [right[i].conjugate()] for i in range(n)]
    rows.append([*column, acb(0)])
    try:
        solved = acb_mat(rows).solve(acb_mat(n + 1, 1, [acb(0)] * n + [acb(1)]))
    except ZeroDivisionError:
        raise NotProvedError from None
    left = [solved[i, 0] for i in range(n)]
    size = dot(left, right)
    if size.contains(0):
        raise NotProvedError
    return [v / size for v in left]


def dot(x: Balls, y: Balls) -> Any:
    """Σ xᵢ yᵢ, without conjugation."""
    return sum((s * t for s, t in zip(x, y, strict=True)), acb(0))


def shifted(matrix: Any, number: Any) -> Any:
    """A - number, complex."""
    n = matrix.nrows()
    return acb_mat(
        [[acb(matrix[i, j]) - (number if i == j else 0) for j in range(n)] for i in range(n)]
    )


def solve(matrix: Any, right: Balls) -> Balls:
    """Solution of a regular complex system."""
    try:
        solution = matrix.solve(acb_mat(len(right), 1, [acb(v) for v in right]))
    except ZeroDivisionError:
        raise NotProvedError from None
    return [solution[i, 0] for i in range(len(right))]


def speeds(line: OneParameterFamily, x: Balls, p: Balls) -> Balls:
    """d/d axis along the family of what is free: 1 for the axis, then what is solved for."""
    _, _, (by_axis, *columns) = line.first(x, p)
    if not line.solved:
        return [arb(1)]
    rows = arb_mat([[column[i] for column in columns] for i in line.rows])
    try:
        turn = rows.solve(arb_mat(len(line.rows), 1, [-by_axis[i] for i in line.rows]))
    except ZeroDivisionError:
        raise NotProvedError from None
    return [arb(1), *[turn[k, 0] for k in range(len(columns))]]


def eigenvalue_speed(pair: Pair, left: Balls, v: Sequence[Any]) -> Any:
    """dλ/d axis = w (dA/d axis) v for a simple eigenvalue with w v = 1."""
    line, kept = pair.line, pair.line.d.kept
    x, p = pair.point
    total = [acb(0)] * len(x)
    for speed, turned in zip(speeds(line, x, p), line.turned(x, p, line.whole(v)), strict=True):
        total = [t + speed * acb(w) for t, w in zip(total, turned, strict=True)]
    return dot(left, [total[i] for i in kept])


@dataclass(frozen=True)
class Coefficients:
    """What decides at a crossing pair, in balls."""

    speed: Any
    """d Re λ / d axis."""
    first: Any
    """l1."""
    others: int
    """1: every other eigenvalue is proved to be stable; -1: one is unstable; 0: open."""


def coefficients(pair: Pair) -> Coefficients:
    """The first Lyapunov coefficient at a crossing pair, and the speed of the crossing.

    Raises
    ------
    NotProvedError
        If zero or twice the pair is not proved to be no eigenvalue.
    """
    line, kept = pair.line, pair.line.d.kept
    x, p = pair.point
    matrix, w, q = pair.matrix, pair.frequency, pair.mode
    left = bordered(shifted(matrix, acb(0, 1) * w), q)
    conjugate = [v.conjugate() for v in q]

    def second(u: Balls, v: Balls) -> Balls:
        derivative = line.second(x, p, line.whole(u), line.whole(v))
        return [acb(derivative[i]) for i in kept]

    cubic = line.third(x, p, line.whole(q), line.whole(q), line.whole(conjugate))
    total = dot(left, [acb(cubic[i]) for i in kept])
    mean = solve(shifted(matrix, acb(0)), second(q, conjugate))
    total = total - 2 * dot(left, second(q, mean))
    double = solve(shifted(matrix, acb(0, 2) * w), [-v for v in second(q, q)])
    total = total + dot(left, second(conjugate, double))
    first = total.real / (2 * w)
    speed = eigenvalue_speed(pair, left, q).real
    return Coefficients(speed, first, others(pair))


def others(pair: Pair, zeros: int = 0) -> int:
    """Whether every eigenvalue but the pair and structural zeros is stable.

    Parameters
    ----------
    pair
        The pair.
    zeros
        Number of structural zeros over the kept states.

    Returns
    -------
    int
        1 stable, -1 one is unstable, 0 open.
    """
    polynomial = pair.matrix.charpoly().coeffs()
    return hurwitz_sign(divided(polynomial, [pair.frequency**2, arb(0), arb(1)])[zeros:])


@dataclass(frozen=True)
class LineForm:
    """Coefficients of a Hopf bifurcation without parameters, in balls."""

    speed: Any
    """Re μ' per unit of the axis."""
    push: Any
    """c for the mode of unit length."""


def line_form(pair: Pair) -> LineForm:
    """The normal form at a crossing pair along a line of steady motions.

    Parameters
    ----------
    pair
        The pair, proved; its axis is a state, so that the family is a line.

    Raises
    ------
    NotProvedError
        If zero is not proved to be a simple eigenvalue.
    """
    line, kept = pair.line, pair.line.d.kept
    x, p = pair.point
    along = dict(zip(line.free, speeds(line, x, p), strict=True))
    states = line.family.system.states
    tangent = [acb(along.get(states[i], 0)) for i in kept]
    matrix, q = pair.matrix, pair.mode
    left = bordered(shifted(matrix, acb(0, 1) * pair.frequency), q)
    across = bordered(shifted(matrix, acb(0)), tangent)

    pushed = line.second(x, p, line.whole(q), line.whole([v.conjugate() for v in q]))
    push = dot(across, [acb(pushed[i]) for i in kept])
    return LineForm(eigenvalue_speed(pair, left, q).real, push.real)


def signed(ball: Any) -> int:
    """Sign of a ball; 0 where it holds zero or is not finite."""
    number = arb(ball)
    if not number.is_finite():
        raise NotProvedError
    return 1 if number > 0 else -1 if number < 0 else 0
