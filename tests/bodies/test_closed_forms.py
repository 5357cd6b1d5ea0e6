"""Formulas of inclined families against the graph: spectra, members, verdicts of maps."""

from __future__ import annotations

from dataclasses import replace
from zlib import crc32

import casadi as ca
import numpy as np
import pytest
from flint import arb, arb_series

import stability as st
from stability.algebra.number_types import balls, numpy_algebra, precision
from stability.algebra.program import Program
from stability.algebra.running_error import TRACKED, RunningError, bounded
from stability.base.verdict import CODES
from stability.bodies.round_body.inclinations import tumbling_ranges
from stability.boundary.interval_search.taylor import series_algebra, terms
from stability.maps import cells
from stability.spectra.problem import formulas_of
from stability.systems.closed_form import ImplicitForm

ROUNDED = st.Body(
    lambda theta, bend: 1 + bend * ca.cos(2 * theta),
    axial=0.4,
    transverse=0.45,
    shape={"bend": 0.1},
    name="rounded",
)
BODIES = {
    "torus": st.Torus(0.2),
    "spheroid": st.Spheroid(0.6),
    "sphere": st.EccentricSphere(0.2),
    "thick disk": st.ThickDisk(0.1),
    "egg": st.Egg(0.2),
    "rounded": ROUNDED,
    "si": st.Torus(0.15, mass=2.0, gravity=9.81, length=0.3),
}
LAWS = [
    ("tumbling", "viscous"),
    ("tumbling", "linear-viscous"),
    ("tumbling", "rough"),
    ("tumbling", "smooth"),
    ("circling", "rough"),
    ("precession", "smooth"),
]


def members(body: st.Body, family: st.Family, count: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Random family parameters and parameters."""
    random = np.random.default_rng(crc32(f"{family.name} {family.system.name}".encode()))
    low, high = max(tumbling_ranges(body), key=lambda r: r[1] - r[0])
    theta = random.uniform(low + 0.1, high - 0.1, count)
    a = [theta] if len(family.at) == 1 else [theta, random.uniform(0.8, 3.0, count)]
    known = {n: np.full(count, float(np.asarray(v))) for n, v in body.given.items()}
    known |= {"mu": random.uniform(0.1, 2, count), "c": random.uniform(0.1, 2, count)}
    return np.array(a).T, np.array([known[n] for n in family.parameters]).T.reshape(count, -1)


@pytest.mark.few(6)
@pytest.mark.parametrize(("name", "law"), LAWS)
@pytest.mark.parametrize(
    "body",
    [pytest.param(b, id=n, marks=[pytest.mark.long] * (n == "egg")) for n, b in BODIES.items()],
)
def test_formulas_give_the_eigenvalues_of_the_jacobian(body: st.Body, name: str, law: str) -> None:
    family = body.family(name, law)
    formulas = formulas_of(family)
    assert formulas is not None
    a, q = members(body, family)
    system = family.system
    jacobian = ca.Function("J", [system.x, system.p], [ca.densify(system.jacobian)])
    place = [
        (system.parameters.index(n))
        for n in (*family.at, *family.parameters)
        if n in system.parameters
    ]
    for at, own, state in zip(a, q, replace(family, formulas=None).member(a, q), strict=True):
        full = np.array(own)[np.argsort(place)] if len(place) else own
        true = np.linalg.eigvals(np.asarray(jacobian(state, full)))
        coefficients, unknowns, positive = formulas(numpy_algebra(), list(at), list(own))
        roots = np.roots(np.array(coefficients, dtype=float)[::-1])
        ours = np.concatenate([roots, np.zeros(formulas.zeros)])
        size = np.abs(true).max()
        # a zero of multiplicity two is off by the root of a rounding in LAPACK, not in a power sum
        for power in range(1, len(true) + 1):
            assert abs((true**power).sum() - (ours**power).sum()) < 1e-11 * size**power
        solved = [state[system.states.index(n)] for n in family.unknown]
        assert np.allclose(unknowns, solved, rtol=1e-11, atol=1e-11)
        assert min(float(v) for v in positive) > 0


AXES = {
    "tumbling": ("theta", 0.9, 1.5, 41),
    "circling": ("theta", 0.4, 1.4, 41),
    "precession": ("theta", 0.4, 1.4, 41),
}


@pytest.mark.few(2)
@pytest.mark.parametrize(("name", "law"), [p for p in LAWS if p[1] != "linear-viscous"])
def test_maps_by_formulas_have_the_verdicts_of_the_graph(
    name: str, law: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = st.ThickDisk(0.2)
    y = ("phi_dot", 0.5, 3.0, 31)
    if name == "tumbling":
        y = ("mu", 0.05, 3.0, 31) if law == "viscous" else ("thickness", 0.05, 0.4, 31)
    ask = {"x": AXES[name], "y": y, "contact": law, "body": body, "boundaries": False}
    fast = st.stability_map(name, **ask)
    monkeypatch.setattr(cells, "formula_cells", lambda *_: None)
    slow = st.stability_map(name, **ask)
    assert "formulas" in fast.attrs["method"]
    assert "formulas" not in slow.attrs["method"]
    both = (fast.verdict.values != 0) & (slow.verdict.values != 0)
    assert both.mean() > 0.99
    assert (fast.verdict.values == slow.verdict.values)[both].all()
    here = both & (fast.verdict.values != CODES.get("no_member", 3))
    gap = np.abs(fast.abscissa - slow.abscissa).values[here]
    bound = (fast.abscissa_error + slow.abscissa_error).values[here]
    finite = np.isfinite(gap)
    assert finite.any()
    assert (gap <= bound)[finite].all()


@pytest.mark.few(2)
@pytest.mark.parametrize("law", ["viscous", "linear-viscous", "rough", "smooth"])
@pytest.mark.parametrize("name", ["thick disk", pytest.param("egg", marks=pytest.mark.long), "si"])
def test_leaning_rolling_has_the_eigenvalues_of_the_jacobian(name: str, law: str) -> None:
    """θ is solved for inside the formulas, in arrays, balls and series alike."""
    body = BODIES[name] if name != "si" else st.ThickDisk(0.15, mass=2.0, gravity=9.81, length=0.3)
    family = body.family("rolling", law)
    formulas = formulas_of(family)
    assert isinstance(formulas, ImplicitForm)
    system = family.system
    jacobian = ca.Function("J", [system.x, system.p], [ca.densify(system.jacobian)])
    known = {n: float(np.asarray(v)) for n, v in body.given.items()} | {"mu": 0.4, "c": 0.7}
    own = [known[n] for n in family.parameters]
    for at in (0.3, 1.1, 2.9):
        state = replace(family, formulas=None).member([at], own)
        true = np.linalg.eigvals(np.asarray(jacobian(state, own)))
        coefficients, unknowns, _ = formulas(numpy_algebra(), [at], own)
        roots = np.roots(np.array(coefficients, dtype=float)[::-1])
        size = np.abs(true).max()
        for power in range(1, len(true) + 1):
            assert abs((true**power).sum() - (roots**power).sum()) < 1e-11 * size**power
        assert abs(float(unknowns[0]) - state[0]) < 1e-12


def test_a_solved_inclination_lies_within_its_bounds() -> None:
    """Tan θ = 2/t for a thick disk; the bound of doubles and the ball hold it, and are narrow."""
    family = st.ThickDisk(0.1).family("rolling", "rough")
    formulas = formulas_of(family)
    assert isinstance(formulas, ImplicitForm)
    thickness = np.linspace(0.03, 0.4, 29)
    near = formulas.solved(TRACKED, [RunningError(thickness, 0.0)])
    with precision(200):
        for t, value, error in zip(thickness, near.value, near.error, strict=True):
            with precision(400):
                true = (arb(2) / arb(t)).atan()
            assert abs(arb(value) - true) <= arb(error)
            assert error < 1e-14
            ball = formulas.solved(balls(), [arb(t)])
            assert ball.contains(true)
            assert float(ball.rad()) < 1e-55
        with terms(3):
            series = formulas.solved(series_algebra(), [arb_series([arb(0.1), 1])])
            slope = -2 / (arb(0.1) ** 2 + 4)  # dθ/dt
            assert series[1].overlaps(slope)
            assert abs(series[1] - slope) < arb(1e-50)


def test_families_of_nearby_numbers_are_one() -> None:
    """What is derived from the graph is then derived once."""
    for name in ("rolling", "tumbling"):
        near = [st.ThickDisk(t).family(name, "viscous") for t in (0.1, 0.1001, 0.104)]
        assert near[0] == near[1] == near[2]
        assert hash(near[0]) == hash(near[2])


def test_another_polynomial_is_not_taken() -> None:
    family = BODIES["torus"].family("tumbling", "rough")
    other = BODIES["spheroid"].family("tumbling", "rough")
    assert formulas_of(replace(family, formulas=other.formulas)) is None


def test_one_bound_covers_every_rounding() -> None:
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    value = ca.sqrt(x * x - y) / (ca.sin(x) - y * y) + ca.cos(x + y) ** 3
    function = ca.Function("f", [x, y], [value])
    program = bounded(function)
    random = np.random.default_rng(4)
    points = random.uniform(1.0, 3.0, (2, 400)) * [[1], [0.3]]
    with np.errstate(all="ignore"):
        (near,), (error,) = program.run(numpy_algebra(), [[points[0]], [points[1]]])
    from flint import arb, ctx

    from stability.algebra.number_types import balls

    before, ctx.prec = ctx.prec, 200
    try:
        for i in range(points.shape[1]):
            exact = Program(function).run(balls(), [[arb(p)] for p in points[:, i]])[0][0]
            if exact.is_finite():
                assert abs(arb(near[i]) - exact) <= arb(error[i])
                assert error[i] > 0
    finally:
        ctx.prec = before


def test_a_root_of_what_may_be_negative_has_no_bound() -> None:
    x = ca.SX.sym("x")
    program = bounded(ca.Function("f", [x], [ca.sqrt(x * x - 2)]))
    with np.errstate(all="ignore"):
        error = program.run(numpy_algebra(), [[np.array([np.sqrt(2.0)])]])[1][0]
    assert not np.isfinite(error).any()


def test_families_of_two_bodies_are_told_apart_without_a_comparison(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    families = [st.Torus(tube).family("rolling", "smooth") for tube in (0.2, 0.5)]
    assert families[0] != families[1]
    assert families[0] == replace(families[0])
    assert hash(families[0]) == hash(replace(families[0]))
    table = {family: i for i, family in enumerate(families)}

    def compared(*_: object) -> bool:
        raise AssertionError("a look-up compares families")

    monkeypatch.setattr(st.Family, "__eq__", compared)
    assert [table[family] for family in families] == [0, 1]


@pytest.mark.few(1)
@pytest.mark.parametrize(("name", "law"), [("tumbling", "viscous"), ("precession", "smooth")])
def test_conditions_by_waves_are_those_of_the_system(name: str, law: str) -> None:
    family = BODIES["egg"].family(name, law)
    formulas = formulas_of(family)
    assert formulas is not None
    a, q = members(BODIES["egg"], family)
    _, unknown, positive = formulas(numpy_algebra(), list(a.T), list(q.T))
    given = dict(zip(family.at, a.T, strict=True)) | family.held
    given |= dict(zip(family.unknown, unknown, strict=True))
    x = np.array(
        [
            np.broadcast_to(float(given[n]) if np.ndim(given[n]) == 0 else given[n], len(a))
            for n in family.system.states
        ]
    )
    found = family.system.condition_program.arrays([list(x), list(q.T)], (len(a),))
    for mine, theirs in zip(positive, found, strict=False):  # φ̇² > 0 is the formulas' own
        np.testing.assert_allclose(mine, theirs[:, 0, 0], rtol=1e-12, atol=1e-13)


def test_conditions_of_many_waves_hold_over_a_whole_piece() -> None:
    """By recurrences the enclosure of D over a piece of this width grows beyond its value."""
    formulas = formulas_of(BODIES["egg"].family("precession", "smooth"))
    assert formulas is not None
    numbers = [arb(float(v)) for v in BODIES["egg"].given.values()]
    _, _, positive = formulas(balls(), [arb("0.8 +/- 0.01"), arb("1.7")], numbers)
    assert all(v > 0 for v in positive)
