"""Maps of bodies: by the polynomial where upright, and no wrong verdict where conditions fail."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.base.verdict import NO_MEMBER, Verdict
from stability.maps.slices import slice_of
from stability.spectra.axes import swept

BODIES = (st.Torus(0.2), st.Spheroid(1.6))


@pytest.mark.few(1)
@pytest.mark.parametrize("law", ["smooth", "viscous", "rough"])
@pytest.mark.parametrize("family", ["rolling", "spinning"])
@pytest.mark.parametrize("body", BODIES, ids=lambda b: f"{b.name} {next(iter(b.shape.values()))}")
def test_an_upright_body_is_mapped_by_its_polynomial(body: st.Body, family: str, law: str) -> None:
    [shape] = body.shape
    middle = float(body.shape[shape])
    mu = {"mu": 0.4} if law == "viscous" else {}
    y = (shape, 0.5 * middle, 1.5 * middle, 32)
    chart = st.stability_map(family, x=("at", 0.3, 3.1, 40), y=y, body=body, contact=law, **mu)
    assert chart.method.startswith("characteristic polynomial of the family over Q")
    assert (chart.verdict != Verdict.UNDECIDED.code).all()
    rng = np.random.default_rng(1)
    for j, i in zip(rng.integers(0, 32, 6), rng.integers(0, 40, 6), strict=True):
        number = float(chart[shape][j])
        own = st.Torus(number) if shape == "tube" else st.Spheroid(number)
        at = float(chart[chart.abscissa.dims[1]][i])
        one = st.spectrum(family, at=at, body=own, contact=law, certify=True, **mu)
        assert chart.verdict.values[j, i] == one.verdict.code
        assert chart.abscissa.values[j, i] == pytest.approx(one.abscissa, rel=1e-9, abs=1e-12)


@pytest.mark.few(1)
@pytest.mark.parametrize("law", ["smooth", "rough"])
def test_the_root_of_a_square_is_read_on_one_side_of_zero(law: str) -> None:
    """At a pole the height of a spheroid is √(aspect²), which is the aspect itself."""
    chart = st.stability_map(
        "vertical",
        x=("at", 0.5, 5.0, 40),
        y=("aspect", 1.1, 2.0, 32),
        body=st.Spheroid(1.5),
        contact=law,
    )
    assert chart.method.startswith("characteristic polynomial of the family over Q")
    assert set(np.unique(chart.verdict)) == {Verdict.NEUTRAL.code, Verdict.UNSTABLE.code}
    rng = np.random.default_rng(2)
    for j, i in zip(rng.integers(0, 32, 8), rng.integers(0, 40, 8), strict=True):
        one = st.spectrum(
            "vertical",
            at=float(chart[chart.abscissa.dims[1]][i]),
            contact=law,
            body=st.Spheroid(float(chart.aspect[j])),
            certify=True,
        )
        assert chart.verdict.values[j, i] == one.verdict.code
        assert chart.abscissa.values[j, i] == pytest.approx(one.abscissa, rel=1e-9, abs=1e-12)


STATE, LIMIT = ca.SX.sym("theta"), ca.SX.sym("c")
ABOVE = st.Condition(STATE - 1, "theta is {value:.3g} above 1")
SINE = st.Condition(ca.sin(STATE) - LIMIT, "the sine is {value:.3g} above c")


def leaning(*conditions: st.Condition) -> st.Family:
    """A rod that is held upright by a stable equation; k decides about the other state."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(ca.cos(x[0]), -p[0] * x[1])
    given = tuple(
        st.Condition(
            ca.substitute(c.value, ca.vertcat(STATE, LIMIT), ca.vertcat(x[0], p[1])), c.sentence
        )
        for c in conditions
    )
    system = st.System(
        "rod", x, p, rates, states=("theta", "v"), parameters=("k", "c"), conditions=given
    )
    return st.Family(system, "upright", at=("k",), held={"theta": st.UPRIGHT, "v": 0.0})


def test_conditions_at_the_right_angle_are_kept() -> None:
    family = leaning(ABOVE, SINE)
    # c = 1 is the sine of the right angle itself, where the condition fails
    chart = st.stability_map(family, x=("k", -1, 1, 40), y=("c", 0.5, 1.5, 33))
    assert chart.method.startswith("characteristic polynomial of the family over Q")
    inside = np.broadcast_to(chart.c.values[:, None] < 1, chart.verdict.shape)
    stable = np.broadcast_to(chart.k.values > 0, chart.verdict.shape)
    assert ((chart.verdict.values == NO_MEMBER) == ~inside).all()
    assert (chart.verdict.values[inside & stable] == Verdict.STABLE.code).all()
    assert (chart.verdict.values[inside & ~stable] == Verdict.UNSTABLE.code).all()


@pytest.mark.parametrize(
    "condition",
    [
        st.Condition(STATE - 2, "theta is {value:.3g} above 2"),  # which the right angle is not
        st.Condition(STATE * LIMIT, "theta times c is {value:.3g}"),  # π/2 is no rational
    ],
)
def test_no_polynomial_where_a_condition_fails_or_is_not_exact(condition: st.Condition) -> None:
    family = leaning(condition)
    x, y = ("k", -1, 1, 40), ("c", 0.5, 1.5, 33)
    try:
        problem, _ = swept(family, {"x": x, "y": y})
    except st.StabilityError:
        problem, _ = swept(leaning(ABOVE), {"x": x, "y": y})
        problem = replace(problem, family=family)
    assert slice_of(problem, "k", "c") is None


def test_a_body_is_streamed_by_its_polynomial(tmp_path: Path) -> None:
    target = tmp_path / "torus.nc"
    axes = {"x": ("phi_dot", 0.5, 5, 16), "y": ("mu", 0.05, 2, 12)}
    st.stream_map("spinning", **axes, out=target, body=st.Torus(0.2))
    whole = st.stability_map("spinning", **axes, body=st.Torus(0.2))
    assert (st.read_map(target).verdict.values == whole.verdict.values).all()


def test_a_map_that_is_decided_by_whole_tiles_at_once() -> None:
    """All tiles of this map are decided at the coarsest level, which leaves none to cut."""
    found = st.stability_map(
        "vertical",
        body=st.EccentricSphere(0.2),
        contact="rough",
        x=("at", 0.5, 5.0, 400),
        y=("offset", 0.05, 0.5, 300),
        boundaries=False,
    )
    corner = st.spectrum(
        "vertical", at=0.5, body=st.EccentricSphere(0.05), contact="rough", certify=True
    )
    assert found.verdict.attrs["flag_meanings"].split()[int(found.verdict.values[0, 0])] == (
        str(corner.verdict.word)
    )


def test_the_first_map_of_a_long_formula_compiles_nothing() -> None:
    script = """
import sys
import stability as st
axes = {"x": ("at", 1.0, 1.7, 30), "y": ("mu", 0.05, 3.0, 40)}
chart = st.stability_map("tumbling", body=st.Egg(0.2), **axes)
assert chart.sizes["boundary_point"] > 10
print("numba" in sys.modules)
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["False"]
