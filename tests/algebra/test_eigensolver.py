"""Another eigensolver: every eigenvalue comes from it, and its errors make no verdict wrong."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest
import scipy.linalg

import stability as st
import stability.spectra.eigenvalues as spectra
from stability.algebra.eigensolver import EigenSolver, eigenpairs, eigensolver, lapack
from stability.settling.box import eigen
from stability.spectra.eigenvalues import _match

EIG = np.linalg.eig
ELSEWHERE = [
    *((np.linalg, n) for n in ("eig", "eigvals", "eigh", "eigvalsh")),
    *((scipy.linalg, n) for n in ("eig", "eigvals", "eigh", "eigvalsh", "schur", "hessenberg")),
    (np, "roots"),
]
"""Everything else by which NumPy and SciPy find eigenvalues."""


class Spied:
    """A backend that counts its calls and matrices."""

    def __init__(self, solver: EigenSolver) -> None:
        self.solver, self.calls, self.matrices = solver, 0, 0

    def __call__(self, matrix: Any) -> tuple[Any, Any]:
        self.calls += 1
        self.matrices += len(matrix)
        return self.solver(matrix)


def digits(matrix: Any) -> tuple[Any, Any]:
    """The QR iteration of mpmath in 30 digits, one matrix after the other."""
    with mpmath.workdps(30):
        found = [mpmath.eig(mpmath.matrix(m.tolist())) for m in matrix]
    values = np.array([[complex(v) for v in one] for one, _ in found])
    vectors = np.array([[[complex(v) for v in row] for row in x.tolist()] for _, x in found])
    return values.reshape(matrix.shape[:-1]), vectors.reshape(matrix.shape)


@pytest.fixture
def only(monkeypatch: pytest.MonkeyPatch) -> Spied:
    """The second backend, with every other eigensolver out of order."""

    def broken(*_: Any, **__: Any) -> Any:
        raise AssertionError("an eigenvalue comes from elsewhere")

    for module, name in ELSEWHERE:
        monkeypatch.setattr(module, name, broken)
    return Spied(digits)


def pendulum() -> st.Family:
    """Hanging and upright; λ² + d λ + g cos(angle)."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rhs = ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - p[1] * x[1])
    system = st.System("pendulum", x, p, rhs, states=("angle", "rate"), parameters=("g", "d"))
    return st.Family(system, "rest", at=("g",), held={"angle": 0.0, "rate": 0.0})


QUESTIONS: dict[str, Callable[[], Any]] = {
    "one": lambda: st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3)),
    "batch": lambda: st.spectrum("spinning", at=[1.5, 2.2, 3.0], contact=st.LinearViscous(0.7)),
    "even": lambda: st.spectrum("tumbling", at=[0.4, 1.1], contact=st.Smooth()),
    "circling": lambda: st.spectrum("circling", at=[1.1, 1.9], contact=st.Rough()),
    "proved": lambda: st.spectrum("tumbling", at=1.1, contact=st.Viscous(0.9), certify=True),
    "user": lambda: st.spectrum(pendulum(), at=[-1.0, 0.5, 2.0], d=[0.3]),
}


@pytest.mark.parametrize("name", QUESTIONS)
def test_spectra_with_modes_are_those_of_the_second_backend(name: str, only: Spied) -> None:
    with eigensolver(only):
        found = QUESTIONS[name]()
    once = only.calls
    modes = found.modes  # outside the context, and by the same backend
    assert only.calls == 1 and once <= 1
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(np.linalg, "eig", EIG)
        known = QUESTIONS[name]()
        assert np.all(known.verdict == found.verdict)
        assert np.all(np.abs(known.eigenvalues - found.eigenvalues) <= known.radius + found.radius)
        overlap = np.abs((known.modes.vectors.conj() * modes.vectors).sum(axis=-1))
        assert np.allclose(overlap, 1, atol=1e-9)
        assert np.all(known.modes.labels == modes.labels)


@pytest.mark.parametrize("name", QUESTIONS)
def test_modes_take_the_vectors_that_the_values_came_with(name: str) -> None:
    with eigensolver(spy := Spied(lapack)):
        found = QUESTIONS[name]()
        assert found.modes.vectors.shape[:-1] == found.eigenvalues.shape
    assert spy.calls == 1 and spy.matrices == max(1, found.codes.size)


def test_many_members_do_not_keep_their_vectors_and_have_the_same_modes(monkeypatch) -> None:
    whole = QUESTIONS["batch"]()
    monkeypatch.setattr("stability.spectra.spectrum.PIECE", 72)
    found = QUESTIONS["batch"]()
    assert found.pairs is None and whole.pairs is not None
    assert np.array_equal(found.modes.vectors, whole.modes.vectors)


@pytest.mark.parametrize(
    "given",
    [
        ({"family": "spinning", "x": ("at", 1.5, 3, 5), "y": ("mu", 0.2, 2, 4)}),
        ({"family": pendulum(), "x": ("g", -1, 2, 5), "y": ("d", -0.5, 1, 4)}),
    ],
    ids=["disk", "user"],
)
def test_maps_are_those_of_the_second_backend(given: dict[str, Any], only: Spied) -> None:
    with eigensolver(only):
        found = st.stability_map(**given)
    assert only.matrices
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(np.linalg, "eig", EIG)
        patch.setattr(np.linalg, "eigvals", lambda m: EIG(m)[0])
        known = st.stability_map(**given)
    assert np.array_equal(found.verdict, known.verdict)
    assert (
        abs(found.abscissa - known.abscissa) <= found.abscissa_error + known.abscissa_error
    ).all()


def test_boundaries_and_hopf_are_those_of_the_second_backend(only: Spied) -> None:
    """They are proved in exact numbers and balls: no eigenvalue in floating point is asked for."""
    with eigensolver(only):
        edges = st.boundaries("spinning", axis=("at", 0.1, 5, 9), contact=st.Viscous(0.97))
        scanned = st.boundaries(pendulum(), axis=("g", -1.0, 2.0, 9), d=0.3)
        points = st.hopf("tumbling", contact=st.Viscous(0.9), disk=st.Disk(k=0.375))
    assert [b.crossing.word for b in edges] == ["static", "flutter"] and len(scanned) == 1
    assert [p.kind.word for p in points] == ["elliptic", "hyperbolic"]
    assert only.calls == 0


def test_launches_choose_their_method_by_the_second_backend(only: Spied) -> None:
    start = {"theta": 1.2, "omega3": 1.0, "slip_x": 1e-4}
    with eigensolver(only):
        stiff = st.simulate(st.Disk(), st.Viscous(900.0), start, 0.05)
    assert only.calls and stiff.attrs["outcome"]
    with eigensolver(lambda m: (0 * m[..., 0], m)):
        assert eigen(np.diag([-1.0, -2.0, -3.0])[None])[3] == 0


def test_a_map_names_its_eigensolver_and_a_checkpoint_belongs_to_it(tmp_path) -> None:
    ask: dict[str, Any] = {"x": ("g", -1, 2, 3), "y": ("d", 0.5, 1, 3), "checkpoint": tmp_path}
    with eigensolver(digits):
        assert "(digits)" in st.stability_map(pendulum(), **ask).attrs["method"]
    with pytest.raises(st.StabilityError, match="another map"):
        st.stability_map(pendulum(), **ask)
    assert "(LAPACK)" in st.stability_map(pendulum(), **ask | {"checkpoint": None}).attrs["method"]


def test_modes_of_equal_eigenvalues_take_each_vector_once() -> None:
    values = np.array([[2.0, 2.0, 1.0], [1.0, 2.0, 3.0]], dtype=complex)
    pick = _match(values, values[:, ::-1])
    assert sorted(pick[0]) == [0, 1, 2] and pick[0][2] == 0 and pick[1].tolist() == [2, 1, 0]


# --- bad backends ---

TRUE = EIG  # before any test puts it out of order
RNG = np.random.default_rng(12)


def _off(size: float, vectors: bool) -> EigenSolver:
    """A backend with errors of a size in its values, and in its vectors."""

    def solver(matrix: Any) -> tuple[Any, Any]:
        values, x = (np.asarray(v, dtype=complex) for v in TRUE(matrix))
        values = values + size * (
            RNG.normal(size=values.shape) + 1j * RNG.normal(size=values.shape)
        )
        return values, x + vectors * size * RNG.normal(size=x.shape)

    return solver


def _shuffled(matrix: Any) -> tuple[Any, Any]:
    values, x = TRUE(matrix)
    return values[..., ::-1], x


BAD: dict[str, EigenSolver] = {
    "values off by 1e-3": _off(1e-3, vectors=False),
    "pairs off by 1e-3": _off(1e-3, vectors=True),
    "pairs off by 1": _off(1.0, vectors=True),
    "shifted to the left": lambda m: (TRUE(m)[0] - 10.0, TRUE(m)[1]),
    "values of other vectors": _shuffled,
    "zeros": lambda m: (np.zeros(m.shape[:-1]), np.broadcast_to(np.eye(m.shape[-1]), m.shape)),
    "one vector": lambda m: (TRUE(m)[0], np.ones(m.shape)),
    "vectors that are no numbers": lambda m: (TRUE(m)[0], np.full(m.shape, np.nan)),
    "a tiny vector": lambda m: (TRUE(m)[0], TRUE(m)[1] * np.geomspace(1e-200, 1, m.shape[-1])),
}


@pytest.mark.few(9)
@pytest.mark.parametrize("name", BAD)
@pytest.mark.parametrize("contact", [st.Viscous(0.3), st.LinearViscous(2.0), st.Rough()])
def test_a_bad_backend_gives_wide_errors_and_no_wrong_verdict(name: str, contact: Any) -> None:
    for family, at in (("rolling", [0.2, 1.3, 1.99, 2.3]), ("tumbling", [0.2, 0.9, 1.3, 1.5])):
        ask = {"at": at, "contact": contact, "disk": st.Disk(k=0.3)}
        known = st.spectrum(family, **ask, certify=True)
        with eigensolver(BAD[name]):
            found = st.spectrum(family, **ask, escalate=False)
            proved = st.spectrum(family, **ask)
        undecided = found.verdict == st.Verdict.UNDECIDED
        assert np.all(undecided | (found.verdict == known.verdict))
        assert np.all(proved.verdict == known.verdict)
        _each_disc_is_honest(found, known)


def _each_disc_is_honest(found: st.Spectrum, known: st.Spectrum) -> None:
    """Every exact eigenvalue is in a disc, and a group of discs that meet holds its number."""
    for values, radius, true in zip(
        found.eigenvalues, found.radius, known.eigenvalues, strict=True
    ):
        far = np.abs(true[:, None] - values[None, :])
        assert (far <= radius).any(axis=1).all()
        reach = radius[:, None] + radius[None, :]
        group = np.abs(values[:, None] - values[None, :]) <= reach
        for _ in values:
            group = group @ group
        for row in group:
            assert (far[:, row] <= radius[row]).any(axis=1).sum() == row.sum()


def test_discs_hold_for_any_vectors_and_any_approximate_inverse(monkeypatch) -> None:
    """A theorem for each y: with a bad one, bad vectors reach the discs of good ones."""
    rng = np.random.default_rng(0)

    def rough(x: Any) -> Any:
        return (np.eye(3) + rng.uniform(-0.13, 0.13, x.shape)) @ np.linalg.inv(x)

    monkeypatch.setattr(spectra, "_inverse", rough)
    bounded = 0
    for _ in range(2000):
        values = 3 * rng.normal(size=3)
        x = np.eye(3) + (rng.random((3, 3)) < 0.3) * rng.normal(size=(3, 3)) * 0.3
        matrix = np.diag(values)
        exact = np.abs(np.linalg.inv(x) @ (matrix @ x - x * values)).sum(axis=1)
        radius = spectra._discs(matrix[None], 0 * matrix[None], values[None], x[None])[0][0]
        assert (exact <= radius * (1 + 1e-9)).all()
        bounded += np.isfinite(radius).all()
    assert bounded > 1000


REFUSED: dict[str, tuple[Any, str]] = {
    "not finite": (lambda m: (TRUE(m)[0] * np.nan, TRUE(m)[1]), "values that are not finite"),
    "one short": (lambda m: (TRUE(m)[0][..., 1:], TRUE(m)[1]), "arrays of shapes"),
    "vectors of one matrix": (lambda m: (TRUE(m)[0], TRUE(m)[1][0]), "arrays of shapes"),
    "values alone": (lambda m: TRUE(m)[0], "returned"),
    "nothing": (lambda _: None, "returned None"),
    "words": (lambda _: ("a", "b"), "returned"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_answer_is_refused_in_a_sentence(name: str) -> None:
    solver, said = REFUSED[name]
    for ask in (
        lambda: st.spectrum("rolling", at=[1.0, 2.0, 3.0], contact=st.Viscous(0.3)),
        lambda: st.stability_map("rolling", x=("at", 1, 2, 5), y=("mu", 0.2, 1, 5)),
        lambda: st.spectrum("tumbling", at=1.1, contact=st.Rough()).modes,
    ):
        with eigensolver(solver), pytest.raises(st.StabilityError, match=said) as error:
            ask()
        assert "it must return finite eigenvalues" in str(error.value)


def test_what_cannot_be_called_is_refused_and_the_context_ends() -> None:
    with pytest.raises(st.StabilityError, match="give a function"), eigensolver(3):  # type: ignore[arg-type]
        pass
    with eigensolver(lambda m: (m[..., 0], m)):
        assert eigenpairs(np.eye(2))[0].tolist() == [1, 0]
    assert eigenpairs(np.eye(2))[0].tolist() == [1, 1]


def test_no_convergence_is_a_sentence() -> None:
    def stuck(_: Any) -> Any:
        raise np.linalg.LinAlgError("Eigenvalues did not converge")

    with eigensolver(stuck), pytest.raises(st.StabilityError, match="do not converge"):
        st.spectrum("rolling", at=1.0, contact=st.Viscous(0.3))


def test_a_solver_of_one_matrix_at_a_time_serves_a_launch_that_settles() -> None:
    # the proof of settling asks for one matrix alone; a solver is given a row of one
    shapes = set()

    def slow(matrices: Any) -> tuple[Any, Any]:
        shapes.add(matrices.ndim)
        pairs = [np.linalg.eig(m) for m in matrices]
        return np.array([v for v, _ in pairs]), np.array([x for _, x in pairs])

    x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    system = st.System(
        "pendulum",
        x,
        c,
        ca.vertcat(x[1], -ca.sin(x[0]) - c * x[1]),
        states=("angle", "rate"),
        parameters=("c",),
    )
    rest = st.Family(system, "rest", at=("c",), held={"angle": 0.0, "rate": 0.0})
    asked = (system, {"c": 0.3}, {"angle": 0.4, "rate": 0.0}, 200.0)
    with eigensolver(slow):
        found = st.simulate(*asked, families=rest)
    assert shapes == {3}
    again = st.simulate(*asked, families=rest)
    assert found.attrs["outcome"] == again.attrs["outcome"] == "settled"
