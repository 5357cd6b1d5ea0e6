"""Linear systems from their matrices, dense, sparse or symbolic."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from ..algebra.switches import no_folding
from ..base.checks import checked
from ..base.errors import ParameterError
from ..base.types import Floats
from .constant_matrix import ConstantMatrix
from .family import Family
from .system import System
from .system_checks import names, title

STATE = ("name", "states", "x", "p", "observables", "units", "quantities", "_matrix")
"""What a linear system is made of."""


class LinearSystem(System):
    """ẋ = A x with a constant matrix; expressions of its rates are made only where they are asked.

    Parameters
    ----------
    name
        Name of the system.
    states
        Names of the states.
    coefficients
        The matrix.
    """

    _matrix: ConstantMatrix

    def __init__(self, name: str, states: tuple[str, ...], coefficients: ConstantMatrix) -> None:
        vars(self).update(
            name=title("the system", name),
            states=states,
            x=ca.SX.sym("x", len(states)),
            p=ca.SX(0, 1),
            observables={},
            units={},
            quantities={},
            _matrix=coefficients,
        )

    @property
    def coefficients(self) -> ConstantMatrix:
        """The matrix."""
        return self._matrix

    def __getstate__(self) -> dict[str, Any]:
        """All but the expressions that were made."""
        return {name: vars(self)[name] for name in STATE}

    def _content(self) -> tuple[Any, ...]:
        return (type(self), self.name, self.states, self.coefficients.content)

    def rates(self, x: ArrayLike, p: ArrayLike, *, checked: bool = False) -> Floats:  # noqa: ARG002
        """A x, as of any system."""
        arguments, _ = self._arguments(x, p)
        rates = np.stack(arguments[0], axis=-1) @ self.coefficients.constant[0].T
        return self._finite(rates[..., None], arguments)[..., 0]

    @cached_property
    def rhs(self) -> ca.SX:
        """A x as an expression."""
        entries, n = self.coefficients, len(self.states)
        matrix = ca.DM.triplet(
            entries.rows.tolist(), entries.columns.tolist(), ca.DM(entries.values), n, n
        )
        with no_folding():
            product = ca.mtimes(ca.SX(matrix), self.x)
            return product if (entries.divisors == 1).all() else product / ca.DM(entries.divisors)


def linear(*matrices: Any, states: Sequence[str] | None = None, name: str = "linear") -> Family:
    """The state of rest of a linear system, from its matrices.

    Parameters
    ----------
    *matrices
        A of ẋ = A x; or M, C and K of M q̈ + C q̇ + K q = 0.  Each is a dense array, a sparse matrix
        of SciPy, or a CasADi matrix.  The symbols in a CasADi matrix are parameters.
    states
        Names of the states, or of the coordinates q, whose rates are then called `q_dot`;
        x0, x1, … or q0, q1, … when left out.
    name
        Name of the system in messages and files.

    Returns
    -------
    Family
        Its one member is x = 0, or with parameters one for each of their values.  `.system` is the
        system.  Of numbers no expression is made before one is asked for, and zeros are not kept.

    Raises
    ------
    ParameterError
        If the matrices are not square, finite and of one size, or M is singular.

    Source: closed forms in tests/systems/test_linear.py.

    Examples
    --------
    >>> import casadi as ca, stability as st
    >>> import scipy.sparse as sp
    >>> A = sp.diags_array([1.0, -3.0, 1.0], offsets=[-1, 0, 1], shape=(200, 200))
    >>> found = st.spectrum(st.linear(A), certify=True)
    >>> found.verdict.word, bool(found.radius.max() < 1e-14)
    ('stable', True)
    >>> mu = ca.SX.sym("mu")
    >>> wheel = st.linear(ca.SX.eye(2), -mu * ca.SX.eye(2), ca.SX([[2, -1], [-1, 2]]))
    >>> st.spectrum(wheel, mu=0.5).verdict.word
    'unstable'
    """
    if len(matrices) not in (1, 3):
        raise ParameterError(f"{len(matrices)} matrices are given; give A, or M, C and K.")
    words = "A" if len(matrices) == 1 else "MCK"
    read = [_read(word, matrix) for word, matrix in zip(words, matrices, strict=True)]
    shapes = [matrix.shape for matrix in read]
    n = int(shapes[0][0])
    if not n or any(shape != (n, n) for shape in shapes):
        said = ", ".join(f"{w} {m} x {k}" for w, (m, k) in zip(words, shapes, strict=True))
        raise ParameterError(f"the matrices are {said}; give square ones of one size.")
    letter = "x" if len(read) == 1 else "q"
    labels = names("states", tuple(f"{letter}{i}" for i in range(n)) if states is None else states)
    if len(labels) != n:
        raise ParameterError(f"states has {len(labels)} names for {n} rows; give one for each row.")
    system = _with_mass(name, labels, *read) if len(read) == 3 else _plain(name, labels, read[0])
    at, held = system.parameters, dict.fromkeys(system.states, 0.0)
    return Family(system, "rest", at=at, held=held)


def _read(word: str, matrix: Any) -> Any:
    """A matrix of symbols as SX, one of numbers as a sparse array of finite doubles."""
    if isinstance(matrix, (ca.SX, ca.DM)) and ca.symvar(ca.SX(matrix)):
        return ca.sparsify(matrix)
    if isinstance(matrix, (ca.SX, ca.DM)):
        matrix = ca.DM(matrix).full()
    array = matrix if sparse.issparse(matrix) else np.asarray(checked(word, matrix))
    if array.ndim != 2:
        raise ParameterError(f"{word} has shape {array.shape}; give a matrix.")
    entries = sparse.coo_array(array)
    entries.sum_duplicates()
    if entries.nnz:
        entries.data = np.asarray(checked(word, entries.data), dtype=float)
    return entries


def _expression(matrix: Any) -> ca.SX:
    if isinstance(matrix, ca.SX):
        return matrix
    rows, columns = (some.tolist() for some in matrix.coords)
    return ca.SX(ca.DM.triplet(rows, columns, ca.DM(matrix.data), *matrix.shape))


def _plain(name: str, states: tuple[str, ...], matrix: Any) -> System:
    if not isinstance(matrix, ca.SX):
        (rows, columns), ones = matrix.coords, np.ones(len(states))
        return LinearSystem(name, states, ConstantMatrix(rows, columns, matrix.data, ones))
    symbols, x = ca.symvar(matrix), ca.SX.sym("x", len(states))
    rates = ca.densify(ca.mtimes(matrix, x))
    return System(name, x, ca.vertcat(*symbols), rates, states, tuple(map(str, symbols)))


def _with_mass(name: str, places: tuple[str, ...], mass: Any, damping: Any, stiff: Any) -> System:
    """The system of M q̈ + C q̇ + K q = 0."""
    n, speeds = len(places), tuple(f"{q}_dot" for q in places)
    three = (mass, damping, stiff)
    if not any(isinstance(matrix, ca.SX) for matrix in three) and _diagonal(mass):
        weights = mass.diagonal()
        if not weights.all():
            raise ParameterError("M is singular; give a mass that is not zero in each row.")
        indices = np.arange(n)
        rows = np.concatenate([indices, stiff.coords[0] + n, damping.coords[0] + n])
        columns = np.concatenate([indices + n, stiff.coords[1], damping.coords[1] + n])
        values = np.concatenate([np.ones(n), -stiff.data, -damping.data])
        divisors = np.concatenate([np.ones(n), weights])
        return LinearSystem(name, places + speeds, ConstantMatrix(rows, columns, values, divisors))
    m, c, k = map(_expression, three)
    symbols, x = ca.symvar(ca.veccat(m, c, k)), ca.SX.sym("x", 2 * n)
    return System.from_mass_matrix(
        name,
        x,
        ca.SX(ca.vertcat(*symbols)) if symbols else ca.SX(0, 1),
        m,
        ca.densify(-ca.mtimes(c, x[n:]) - ca.mtimes(k, x[:n])),
        unknowns=tuple(f"d_{v}" for v in speeds),
        rates={q: x[n + i] for i, q in enumerate(places)},
        states=places + speeds,
        parameters=tuple(map(str, symbols)),
    )


def _diagonal(matrix: Any) -> bool:
    return bool((matrix.coords[0] == matrix.coords[1])[matrix.data != 0].all())
