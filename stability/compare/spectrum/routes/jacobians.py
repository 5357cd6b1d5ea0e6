"""The routes that people take from equations of motion to eigenvalues and a verdict."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import ClassVar

import numpy as np

from ....algebra.number_types import Algebra
from ....algebra.program import Program
from ....base.types import Complexes, Floats
from ....base.verdict import CODES, Verdict
from ..points import Points
from .route import SMALL, Answer, Route

# --- differences of the rates ---


def rates(points: Points, x: Floats) -> Floats:
    """Rates at states of the points' disks, without a check that the states have a meaning.

    Parameters
    ----------
    points
        Points, of which only law and parameters are used.
    x
        States, shape (N, n).

    Returns
    -------
    ndarray
        Shape (N, n).
    """
    arguments = [list(x.T), list(points.parameters.T)]
    found: Floats = _rates(points.law).arrays(arguments, (len(points),))[0][..., 0]
    return found


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
    step = 1e-4


class ShortForwardDifferences(ForwardDifferences):
    """Forward differences with a step that is too short."""

    name, title = "forward-1e-12", "as forward, step 1e-12"
    step = 1e-12


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


def _complex_algebra() -> Algebra:
    from ....algebra.number_types import numpy_algebra

    plain = numpy_algebra()
    return replace(plain, name="complex numpy", constant=complex)


@lru_cache(maxsize=8)
def _rates(law: str) -> Program:
    """The right-hand side as a program, with its structural zeros written out."""
    import casadi as ca

    from ....bodies.thin_disk import disk_system

    system = disk_system(law)
    return Program(ca.Function("rates", [system.x, system.p], [ca.densify(system.rhs)]))


_COMPLEX = _complex_algebra()


# --- automatic and symbolic Jacobians ---


@lru_cache(maxsize=8)
def jacobian_program(law: str) -> Program:
    """The Jacobian of the rates as a program; built once for each law.

    Parameters
    ----------
    law
        A key of `stability.bodies.contact_laws.LAWS`.

    Returns
    -------
    Program
    """
    import casadi as ca

    from ....bodies.thin_disk import disk_system

    system = disk_system(law)
    return Program(ca.Function("jacobian", [system.x, system.p], [system.jacobian]))


def automatic(points: Points) -> Floats:
    """CasADi's Jacobian of the rates at the points, in doubles.

    Parameters
    ----------
    points
        The points.

    Returns
    -------
    ndarray
        Shape (N, n, n).
    """
    arguments = [list(points.states.T), list(points.parameters.T)]
    found: Floats = jacobian_program(points.law).arrays(arguments, (len(points),))[0]
    return found


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

    def judged(self, points: Points, values: Complexes) -> Answer:  # noqa: ARG002
        """Every eigenvalue counts, structural zeros too."""
        abscissa = values.real.max(axis=1)
        codes = np.where(abscissa > 0, CODES[Verdict.UNSTABLE], CODES[Verdict.STABLE])
        codes = np.where(abscissa == 0, CODES[Verdict.NEUTRAL], codes)
        return Answer(codes.astype(np.int8), None, abscissa)


class AutomaticTolerance(AutomaticJacobian):
    """`AutomaticJacobian` in which all eigenvalues and real parts below 1e-9 count as zero."""

    name, title = "ad-1e-9", "as ad, but what is below 1e-9 counts as zero"
    small = SMALL

    def judged(self, points: Points, values: Complexes) -> Answer:
        """Verdict and abscissa of the eigenvalues above 1e-9, structural or not."""
        abscissa = np.where(np.abs(values) > SMALL, values.real, -np.inf).max(axis=1)
        abscissa = np.where(np.isfinite(abscissa), abscissa, 0.0)
        codes = super().judged(points, values)
        flags = np.full(len(points), CODES[Verdict.NEUTRAL], dtype=np.int8)
        flags[abscissa > SMALL] = CODES[Verdict.UNSTABLE]
        flags[abscissa < -SMALL] = CODES[Verdict.STABLE]
        return Answer(flags, codes.eigenvalues, abscissa)


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

    def answer(self, points: Points) -> Answer:
        """Roots of each polynomial, structural zeros divided out."""
        polynomials = _faddeev(automatic(points))
        kept = polynomials[:, : polynomials.shape[1] - points.zeros]
        values = np.array([np.roots(row) for row in kept])
        return self.judged(points, np.pad(values, ((0, 0), (points.zeros, 0))))


class Hurwitz(Route):
    """The signs of Routh's array in doubles: a verdict without eigenvalues."""

    name, title = "hurwitz", "characteristic polynomial in doubles; signs of Routh's array"

    def answer(self, points: Points) -> Answer:
        """Verdicts alone."""
        polynomials = _faddeev(automatic(points))
        kept = polynomials[:, : polynomials.shape[1] - points.zeros]
        codes = [self._even(row) if points.even else self._routh(row) for row in kept]
        return Answer(np.array([CODES[c] for c in codes], dtype=np.int8))

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
            here, below = (
                below,
                [a - ratio * b for a, b in zip(here[1:], padded, strict=False)],
            )
        return Verdict.STABLE if min(first) > 0 else Verdict.UNSTABLE


def _faddeev(matrices: Floats) -> Floats:
    """Coefficients of det(λ - A), highest first, shape (N, n + 1)."""
    n = matrices.shape[-1]
    coefficients = [np.ones(len(matrices))]
    power = np.broadcast_to(np.eye(n), matrices.shape)
    for i in range(1, n + 1):
        product = matrices @ power
        coefficients.append(-np.trace(product, axis1=1, axis2=2) / i)
        power = product + coefficients[-1][:, None, None] * np.eye(n)
    return np.stack(coefficients, axis=-1)
