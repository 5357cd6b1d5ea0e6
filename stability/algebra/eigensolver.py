"""Eigenvalues of matrices in floating point: LAPACK, or another solver of the caller's choice.

Every eigenvalue of a linearisation comes from here, and so does every spectrum, map and verdict.
(Symmetric matrices of a quadratic form and roots of a polynomial in dry friction do not.)
No assumption is made about a solver's error: error discs come from residuals, proofs from exact
numbers and balls.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import numpy as np

from ..base.errors import DomainError, ParameterError, shown
from ..base.types import Complexes, Floats

EigenSolver = Callable[[Floats], tuple[Any, Any]]
"""Real matrices, shape (N, n, n) → eigenvalues (N, n), and eigenvectors as columns (N, n, n)."""


def lapack(matrix: Floats) -> tuple[Any, Any]:
    """LAPACK's dgeev, the default."""
    return np.linalg.eig(matrix)


_CHOSEN: ContextVar[EigenSolver] = ContextVar("eigensolver", default=lapack)


@contextmanager
def eigensolver(solver: EigenSolver) -> Iterator[None]:
    """A context in which every eigenvalue of a linearisation comes from another solver.

    Parameters
    ----------
    solver
        Function from real matrices, shape (N, n, n), to their eigenvalues, shape (N, n), and
        eigenvectors of any norm as columns, shape (N, n, n).  A real eigenvalue has imaginary
        part 0 and a real vector.  A solver that does not converge raises
        `numpy.linalg.LinAlgError`.  Maps call the solver from several threads at once.  A solver
        with large errors gives wide error discs; verdicts are then proved by other means or stay
        undecided.

    Examples
    --------
    >>> import numpy as np, stability as st
    >>> def slow(matrices):  # one matrix at a time
    ...     pairs = [np.linalg.eig(m) for m in matrices]
    ...     return np.array([v for v, _ in pairs]), np.array([x for _, x in pairs])
    >>> with eigensolver(slow):
    ...     st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3)).verdict.word
    'stable'
    """
    if not callable(solver):
        raise ParameterError(
            f"solver is {shown(solver)}; give a function from matrices to (values, vectors)."
        )
    token = _CHOSEN.set(solver)
    try:
        yield
    finally:
        _CHOSEN.reset(token)


def chosen() -> EigenSolver:
    """The solver of this context."""
    return _CHOSEN.get()


def eigenpairs(matrix: Floats, solver: EigenSolver | None = None) -> tuple[Complexes, Complexes]:
    """Eigenvalues and eigenvectors of finite matrices.

    Parameters
    ----------
    matrix
        Shape (…, n, n).
    solver
        The solver; the context's solver when left out.

    Returns
    -------
    values, vectors
        Shapes (…, n) and (…, n, n), eigenvectors as columns; without any bound on their errors.

    Raises
    ------
    DomainError
        If LAPACK does not converge, or another solver gives a value that is not finite.
    ParameterError
        If a solver does not return arrays of these shapes.
    """
    solver = solver or chosen()
    try:
        pairs = solver(matrix) if solver is lapack else _by_rows(solver, matrix)
    except np.linalg.LinAlgError:
        raise DomainError("the eigenvalues do not converge; give values nearer to 1.") from None
    values, vectors = pairs
    return values.astype(complex), vectors.astype(complex)


def _by_rows(solver: EigenSolver, matrix: Floats) -> tuple[Complexes, Complexes]:
    """Checked results of another solver for matrices stacked along one axis."""
    rows = matrix.reshape(-1, *matrix.shape[-2:])
    pairs = solver(rows)
    try:
        values, vectors = (np.asarray(part).astype(complex) for part in pairs)
    except (TypeError, ValueError):
        raise ParameterError(_refusal(solver, shown(pairs), rows)) from None
    if (values.shape, vectors.shape) != (rows.shape[:-1], rows.shape):
        shapes = f"arrays of shapes {values.shape} and {vectors.shape}"
        raise ParameterError(_refusal(solver, shapes, rows))
    if not np.isfinite(values).all():
        raise DomainError(_refusal(solver, "values that are not finite", rows))
    return values.reshape(matrix.shape[:-1]), vectors.reshape(matrix.shape)


def eigenvalues_alone(matrix: Floats) -> Complexes:
    """Eigenvalues of finite matrices, where no eigenvector is needed.

    Parameters
    ----------
    matrix
        Shape (…, n, n).
    """
    if chosen() is lapack:  # LAPACK finds values alone at less cost
        return np.linalg.eigvals(matrix).astype(complex)
    return eigenpairs(matrix)[0]


def name_of(solver: EigenSolver) -> str:
    """Name of a solver in a method's description."""
    return "LAPACK" if solver is lapack else str(getattr(solver, "__name__", shown(solver)))


def _refusal(solver: EigenSolver, value: str, matrix: Floats) -> str:
    return (
        f"the eigensolver {name_of(solver)} returned {value} for matrices of shape {matrix.shape}; "
        "it must return finite eigenvalues (N, n) and eigenvectors as columns (N, n, n)."
    )
