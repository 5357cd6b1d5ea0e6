"""Routes from a steady motion to eigenvalues and a verdict: those of people, and the package's.

A route is one class with `matrices` if it goes through LAPACK, or with `answer` otherwise.  All
routes get the members as doubles, the equations of motion, and the number of structural zeros,
which is more than people know.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ...algebra.number_types import Algebra, numpy_algebra
from ...algebra.program import Program
from ...algebra.upright import UPRIGHT
from ...base.checks import known
from ...base.types import Complexes, Floats
from ...base.verdict import CODES, Verdict
from ...bodies.disk import Disk
from ...bodies.families import FAMILIES
from ...bodies.thin_disk import disk_system
from ...spectra.certificate import verdict
from ...spectra.result import Spectrum
from ...spectra.spectrum import spectrum
from ...systems.family import Family
from ..marks import Method
from .points import Points

SMALL = 1e-9
"""Real parts up to this count as zero in people's scripts."""


@dataclass(frozen=True, eq=False)
class SpectrumAnswer:
    """Answer of a route at N points."""

    codes: NDArray[np.int8]
    """Verdict flags, shape (N,)."""
    eigenvalues: Complexes | None = None
    """Eigenvalues without structural zeros, shape (N, n); None if the route has none."""
    abscissa: Floats | None = None
    """Largest real part, shape (N,); None if the route has none."""
    bound: Floats | None = None
    """The route's own bound on the error of the abscissa, shape (N,); None if it states none."""


def check(points: Points, answer: SpectrumAnswer) -> None:
    """Refuse an answer of a wrong shape or type.

    Raises
    ------
    ArithmeticError
        If a shape or type is wrong, or a number is not finite.
    """
    count, codes = len(points), np.asarray(answer.codes)
    if codes.shape != (count,) or codes.dtype.kind not in "iu":
        raise ArithmeticError(f"verdicts of shape {codes.shape} for {count} points")
    if not np.isin(codes, list(CODES.values())).all():
        raise ArithmeticError("verdict flags that mean nothing")
    wide = points.member.system.x.numel() - points.zeros
    for name, shape in (("eigenvalues", (count, wide)), ("abscissa", (count,))):
        values = getattr(answer, name)
        if values is not None and (
            np.shape(values) != shape or not np.isfinite(np.asarray(values, dtype=complex)).all()
        ):
            raise ArithmeticError(f"{name} of a wrong shape, or not finite")


class Route(Method):
    """Base class of routes to spectra.

    `matrices` returns the linearisation at each point.  The rest follows as in people's scripts:
    LAPACK, the smallest moduli dropped as structural zeros, the largest real part compared with
    `small`.  A route of another kind overrides `answer`.
    """

    charted: ClassVar[bool] = True
    """Whether the charts have it; the catalogue of failures has every route."""
    arrays: ClassVar[bool] = True
    """Whether it takes many points at once, which makes the time per point shorter."""
    small: ClassVar[float] = SMALL
    """Real parts up to this count as zero."""

    def matrices(self, points: Points) -> Floats:
        """The linearisation, shape (N, n, n)."""
        raise NotImplementedError

    def answer(self, points: Points) -> SpectrumAnswer:
        """Eigenvalues and verdicts at points."""
        return self.judged(points, np.linalg.eigvals(self.matrices(points)).astype(complex))

    def at_state(self, points: Points) -> SpectrumAnswer:
        """The answer at states that may not be steady: most routes do not check."""
        return self.answer(points)

    def judged(self, points: Points, values: Complexes) -> SpectrumAnswer:
        """The answer from all eigenvalues, structural zeros included."""
        order = np.argsort(np.abs(values), axis=1, kind="stable")[:, points.zeros :]
        kept = np.take_along_axis(values, order, axis=1)
        abscissa = kept.real.max(axis=1)
        codes = np.full(len(points), CODES[Verdict.NEUTRAL], dtype=np.int8)
        codes[abscissa > self.small] = CODES[Verdict.UNSTABLE]
        codes[abscissa < -self.small] = CODES[Verdict.STABLE]
        return SpectrumAnswer(codes, kept, abscissa)


# --- differences of the rates ---


def rates(points: Points, x: Floats) -> Floats:
    """Rates at states (N, n) of the points' disks, which need have no meaning."""
    arguments = [list(x.T), list(points.parameters.T)]
    values: Floats = _rates(points.law).arrays(arguments, (len(points),))[0][..., 0]
    return values


class ForwardDifferences(Route):
    """Columns (f(x + h e) - f(x)) / h with h = √ε."""

    name, title = "forward", "Jacobian by forward differences, step 1.5e-8; LAPACK"
    step: ClassVar[float] = 2.0**-26

    def matrices(self, points: Points) -> Floats:
        """The Jacobian at each point, shape (N, n, n)."""
        x = points.states
        base = rates(points, x)
        columns = []
        for j in range(x.shape[1]):
            moved = x.copy()
            moved[:, j] += self.step
            columns.append((rates(points, moved) - base) / self.step)
        return np.stack(columns, axis=-1)


class LongForwardDifferences(ForwardDifferences):
    """Forward differences with a step that is too long."""

    name, title = "forward-1e-4", "as forward, step 1e-4"
    step, charted = 1e-4, False


class ShortForwardDifferences(ForwardDifferences):
    """Forward differences with a step that is too short."""

    name, title = "forward-1e-12", "as forward, step 1e-12"
    step, charted = 1e-12, False


class CentralDifferences(Route):
    """Columns (f(x + h e) - f(x - h e)) / 2h with h = ε^(1/3)."""

    name, title = "central", "Jacobian by central differences, step 6e-6; LAPACK"
    step: ClassVar[float] = float(np.finfo(float).eps) ** (1 / 3)

    def matrices(self, points: Points) -> Floats:
        """The Jacobian at each point, shape (N, n, n)."""
        x, columns = points.states, []
        for j in range(x.shape[1]):
            up, down = x.copy(), x.copy()
            up[:, j] += self.step
            down[:, j] -= self.step
            columns.append((rates(points, up) - rates(points, down)) / (2 * self.step))
        return np.stack(columns, axis=-1)


class ComplexStep(Route):
    """Im f(x + i h e) / h with h = 1e-30: no difference, no cancellation (Squire & Trapp 1998)."""

    name, title = "complex-step", "Jacobian by complex steps of 1e-30; LAPACK"
    step: ClassVar[float] = 1e-30

    def matrices(self, points: Points) -> Floats:
        """The Jacobian at each point, shape (N, n, n)."""
        program = _rates(points.law)
        x, p = points.states.astype(complex), points.parameters
        columns = []
        for j in range(x.shape[1]):
            moved = x.copy()
            moved[:, j] += 1j * self.step
            values = program.run(_COMPLEX, [list(moved.T), list(p.T)])[0]
            columns.append(np.stack(np.broadcast_arrays(*values), axis=-1).imag / self.step)
        return np.stack(columns, axis=-1)


@lru_cache(maxsize=8)
def _rates(law: str) -> Program:
    """The right-hand side as a program, with its structural zeros written out."""
    system = disk_system(law)
    return Program(ca.Function("rates", [system.x, system.p], [ca.densify(system.rhs)]))


_COMPLEX = replace(numpy_algebra(), name="complex numpy", constant=complex)


# --- automatic and symbolic Jacobians ---


@lru_cache(maxsize=8)
def jacobian_program(law: str) -> Program:
    """The Jacobian of the rates as a program; built once for each law."""
    system = disk_system(law)
    return Program(ca.Function("jacobian", [system.x, system.p], [system.jacobian]))


def automatic(points: Points) -> Floats:
    """CasADi's Jacobian of the rates at the points, in doubles; shape (N, n, n)."""
    arguments = [list(points.states.T), list(points.parameters.T)]
    jacobians: Floats = jacobian_program(points.law).arrays(arguments, (len(points),))[0]
    return jacobians


class AutomaticJacobian(Route):
    """CasADi's Jacobian of the rates, LAPACK, and the sign of the largest real part."""

    name, title = "ad", "automatic differentiation; eigenvalues by LAPACK; their signs as they come"
    small = 0.0

    def matrices(self, points: Points) -> Floats:
        """The Jacobian at each point, shape (N, n, n)."""
        return automatic(points)


class AutomaticRaw(AutomaticJacobian):
    """`AutomaticJacobian` with the zeros left in, as in a first script."""

    name, title = "ad-raw", "as ad, but the zeros that structure demands are left in"
    charted = False

    def judged(self, points: Points, values: Complexes) -> SpectrumAnswer:  # noqa: ARG002
        """Every eigenvalue counts, structural zeros too."""
        abscissa = values.real.max(axis=1)
        codes = np.where(abscissa > 0, CODES[Verdict.UNSTABLE], CODES[Verdict.STABLE])
        codes = np.where(abscissa == 0, CODES[Verdict.NEUTRAL], codes)
        return SpectrumAnswer(codes.astype(np.int8), None, abscissa)


class AutomaticTolerance(AutomaticJacobian):
    """`AutomaticJacobian` in which all eigenvalues and real parts below 1e-9 count as zero."""

    name, title = "ad-1e-9", "as ad, but what is below 1e-9 counts as zero"
    small = SMALL

    def judged(self, points: Points, values: Complexes) -> SpectrumAnswer:
        """Verdict and abscissa of the eigenvalues above 1e-9, structural or not."""
        abscissa = np.where(np.abs(values) > SMALL, values.real, -np.inf).max(axis=1)
        abscissa = np.where(np.isfinite(abscissa), abscissa, 0.0)
        codes = super().judged(points, values)
        flags = np.full(len(points), CODES[Verdict.NEUTRAL], dtype=np.int8)
        flags[abscissa > SMALL] = CODES[Verdict.UNSTABLE]
        flags[abscissa < -SMALL] = CODES[Verdict.STABLE]
        return SpectrumAnswer(flags, codes.eigenvalues, abscissa)


class SymbolicJacobian(Route):
    """SymPy's equations with the mass matrix kept, differentiated and lambdified."""

    name, title = "sympy", "equations derived and linearised by SymPy, mass matrix kept; LAPACK"

    def matrices(self, points: Points) -> Floats:
        """The Jacobian at each point, shape (N, n, n)."""
        from .sympy_disk import kept_mass

        return kept_mass(points.law)(points.states, points.parameters)


class SolvedSymbolically(Route):
    """SymPy's equations solved for the accelerations first, which leaves 1/cosθ."""

    name, title = "sympy-solved", "equations solved for the accelerations by SymPy; LAPACK"
    charted = False
    flaw = (
        "SymPy solves for the accelerations in the order of the equations as written, and so "
        "divides by cos θ and by μ v_y. On a steady motion without slip the result is 0/0, though "
        "every such quotient has a limit. It stands here since the step is a common one. The same "
        "equations with the mass matrix kept (sympy) do not crash."
    )

    def matrices(self, points: Points) -> Floats:
        """The Jacobian at each point, shape (N, n, n)."""
        from .sympy_disk import solved

        return solved(points.law)(points.states, points.parameters)


# --- polynomials ---


class PolynomialRoots(Route):
    """Characteristic polynomial in doubles by Faddeev and LeVerrier, then `numpy.roots`."""

    name, title = "polynomial", "characteristic polynomial in doubles; its roots by numpy.roots"

    def answer(self, points: Points) -> SpectrumAnswer:
        """Roots of each polynomial, structural zeros divided out."""
        polynomials = _faddeev(automatic(points))
        kept = polynomials[:, : polynomials.shape[1] - points.zeros]
        values = np.array([np.roots(row) for row in kept])
        return self.judged(points, np.pad(values, ((0, 0), (points.zeros, 0))))


class Hurwitz(Route):
    """The signs of Routh's array in doubles: a verdict without eigenvalues."""

    name, title = "hurwitz", "characteristic polynomial in doubles; signs of Routh's array"

    def answer(self, points: Points) -> SpectrumAnswer:
        """Verdicts alone."""
        polynomials = _faddeev(automatic(points))
        kept = polynomials[:, : polynomials.shape[1] - points.zeros]
        codes = [self._even(row) if points.even else self._routh(row) for row in kept]
        return SpectrumAnswer(np.array([CODES[c] for c in codes], dtype=np.int8))

    @staticmethod
    def _even(row: Floats) -> Verdict:
        return Verdict.UNSTABLE if row[-1] < 0 else Verdict.NEUTRAL

    @staticmethod
    def _routh(row: Floats) -> Verdict:
        here, below = list(row[::2]), list(row[1::2])
        first = [here[0]]
        while below:
            first.append(below[0])
            if below[0] == 0:
                return Verdict.NEUTRAL
            ratio, padded = here[0] / below[0], [*below[1:], 0.0]
            rest = [a - ratio * b for a, b in zip(here[1:], padded, strict=False)]
            here, below = below, rest
        return Verdict.STABLE if min(first) > 0 else Verdict.UNSTABLE


def _faddeev(matrices: Floats) -> Floats:
    """Coefficients of det(λ - A), highest first, shape (N, n + 1), as a user would find them."""
    n = matrices.shape[-1]
    coefficients = [np.ones(len(matrices))]
    power = np.broadcast_to(np.eye(n), matrices.shape)
    for i in range(1, n + 1):
        product = matrices @ power
        coefficients.append(-np.trace(product, axis1=1, axis2=2) / i)
        power = product + coefficients[-1][:, None, None] * np.eye(n)
    return np.stack(coefficients, axis=-1)


# --- many digits ---


class ManyDigits(Route):
    """The AD Jacobian's graph and a QR iteration in mpmath's arithmetic."""

    name, title = "mpmath-30", "automatic differentiation; eigenvalues by mpmath, 30 digits"
    arrays = False
    digits: ClassVar[int] = 30

    def answer(self, points: Points) -> SpectrumAnswer:
        """Eigenvalues and verdicts, point by point."""
        import mpmath

        rows = []
        with mpmath.workdps(self.digits):
            for x, p in zip(self._states(points), points.parameters, strict=True):
                rows.append(self._spectrum(points, x, p))
        values = np.array([[complex(v) for v in row] for row in rows])
        tops = np.array([float(max(v.real for v in row)) for row in rows])
        codes = [CODES[self._verdict(row)] for row in rows]
        return SpectrumAnswer(np.array(codes, dtype=np.int8), values, tops)

    def _states(self, points: Points) -> list[list[Any]]:
        """The states to all digits, upright and solved values included."""
        import mpmath

        record, rows = FAMILIES[points.family], []
        for i, row in enumerate(points.states):
            state: list[Any] = [float(v) for v in row]
            if points.free_states is None:
                at = mpmath.mpf(float(points.at[i]))
                if points.lean is not None:
                    at = mpmath.pi / 2 - mpmath.mpf(float(points.lean[i]))
                member = record.member(mpmath, at, mpmath.mpf(float(points.k[i])))
                state = [member[name] for name in points.member.system.states]
            rows.append([mpmath.pi / 2 if v is UPRIGHT else mpmath.mpf(v) for v in state])
        return rows

    def _spectrum(self, points: Points, x: list[Any], p: Floats) -> list[Any]:
        import mpmath

        program = jacobian_program(points.law)
        q = [mpmath.mpf(float(v)) for v in p]
        matrix = mpmath.matrix(program.dense(_mpmath_algebra(), [x, q]))
        values = sorted(mpmath.eig(matrix, left=False, right=False), key=abs)
        return list(values[points.zeros :])

    def _verdict(self, values: list[Any]) -> Verdict:
        top = max(v.real for v in values)
        # the distance by which rounding may split a double root
        small = 10.0 ** (-self.digits // 2 + 3)
        if abs(top) <= small * max(1, max(abs(v) for v in values)):
            return Verdict.NEUTRAL
        return Verdict.UNSTABLE if top > 0 else Verdict.STABLE


class MoreDigits(ManyDigits):
    """`ManyDigits` with 50 digits."""

    name, title = "mpmath-50", "automatic differentiation; eigenvalues by mpmath, 50 digits"
    digits = 50


class MostDigits(ManyDigits):
    """`ManyDigits` with 100 digits."""

    name, title = "mpmath-100", "automatic differentiation; eigenvalues by mpmath, 100 digits"
    digits = 100


@lru_cache(maxsize=1)
def _mpmath_algebra() -> Algebra:
    import mpmath

    return Algebra(
        "mpmath",
        lambda v: mpmath.mpf(v),
        {
            "sin": mpmath.sin,
            "cos": mpmath.cos,
            "tan": mpmath.tan,
            "sqrt": mpmath.sqrt,
            "exp": mpmath.exp,
            "pow": mpmath.power,
            "fabs": mpmath.fabs,
        },
        lasting=False,  # a constant has the digits of one route
    )


# --- the package ---


def _somewhere(points: Points, *, certify: bool) -> Spectrum:
    """Spectrum of a family that claims the given state; the package checks that it is steady."""
    assert points.free_states is not None
    system, law = disk_system(points.law), points.contact()
    held = dict(zip(system.states, points.free_states[0].tolist(), strict=True))
    at = held.pop("omega3")
    family = Family(
        system,
        "claimed",
        ("omega3",),
        held=held,
        unknown={},
        equations=(),
        typical={"omega3": at, "k": 0.3, "mu": 0.7},
        conservative=law.conservative,
    )
    p = dict(zip(system.parameters, points.parameters[0].tolist(), strict=True))
    return spectrum(family, at=at, certify=certify, **p)


def _spectrum_answer(result: Spectrum) -> SpectrumAnswer:
    return SpectrumAnswer(
        np.atleast_1d(result.codes),
        np.atleast_2d(result.eigenvalues),
        np.atleast_1d(result.abscissa),
        np.atleast_1d(result.abscissa_error),
    )


def _arguments(points: Points) -> dict[str, Any]:
    place = {"at": points.at} if points.lean is None else {"lean": points.lean}
    return {**place, "disk": Disk(k=points.k), "contact": points.contact()}


class Deflated(Route):
    """`spectrum`: each eigenvalue in a disc; points that the discs leave open are certified."""

    name, title = "spectrum", "spectrum(): discs about eigenvalues; what they leave open is proved"
    own, default = True, True
    certify: ClassVar[bool] = False

    def answer(self, points: Points) -> SpectrumAnswer:
        """Call `spectrum` with all points at once."""
        arguments: dict[str, Any] = _arguments(points)
        return _spectrum_answer(spectrum(points.family, certify=self.certify, **arguments))

    def at_state(self, points: Points) -> SpectrumAnswer:
        """Call `spectrum` with a user's family that claims the state."""
        return _spectrum_answer(_somewhere(points, certify=self.certify))


class Certified(Deflated):
    """`spectrum(certify=True)`: rational arithmetic and balls."""

    name, title = "certified", "spectrum(certify=True): rational arithmetic and balls"
    default, arrays, certify = False, False, True


class ExactVerdict(Route):
    """A proved verdict alone, point by point."""

    name, title = "exact-verdict", "exact conditions over Q; a verdict alone"
    own, arrays = True, False

    def answer(self, points: Points) -> SpectrumAnswer:
        """Call `stability.spectra.certificate.verdict` at each point."""
        problem = points.problem()
        rows = zip(
            *(np.broadcast_to(v, (len(points),)).tolist() for v in problem.values.values()),
            strict=True,
        )
        ones = (dict(zip(problem.values, row, strict=True)) for row in rows)
        codes = [CODES[verdict(problem, numbers)] for numbers in ones]
        return SpectrumAnswer(np.array(codes, dtype=np.int8))


OWN: tuple[type[Route], ...] = (Deflated, Certified, ExactVerdict)
"""The package's routes."""


# --- every route ---

PEOPLE: tuple[type[Route], ...] = (
    LongForwardDifferences,
    ForwardDifferences,
    ShortForwardDifferences,
    CentralDifferences,
    ComplexStep,
    AutomaticRaw,
    AutomaticJacobian,
    AutomaticTolerance,
    SymbolicJacobian,
    SolvedSymbolically,
    PolynomialRoots,
    Hurwitz,
    ManyDigits,
    MoreDigits,
    MostDigits,
)
"""Routes that people use."""
ROUTES: dict[str, type[Route]] = {r.name: r for r in (*PEOPLE, *OWN)}
"""Every route by name."""


def route(name: str) -> Route:
    """A route by its name.

    Raises
    ------
    NameUnknownError
        If there is none.

    Examples
    --------
    >>> route("complex-step").title
    'Jacobian by complex steps of 1e-30; LAPACK'
    """
    return ROUTES[known("route", name, ROUTES)]()
