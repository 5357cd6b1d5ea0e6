"""Boundaries and maps of Python functions: by floats, called so, and never against a proof.

Oracles: closed forms, and the same equations as CasADi graphs with proofs.
"""

from __future__ import annotations

import warnings
from typing import Any

import casadi as ca
import numpy as np
import pytest
from matplotlib.text import Text

import stability as st
from stability.base.verdict import Evidence

quiet = pytest.mark.filterwarnings("ignore::stability.StabilityWarning")


def at_origin(function: Any, states: str = "x", parameters: str = "a b") -> st.Family:
    """The origin of x' = f(x, p), named by the first parameter."""
    names, numbers = tuple(states.split()), tuple(parameters.split())
    system = st.System.from_function(function, name="f", states=names, parameters=numbers)
    return st.Family(system, "origin", at=numbers[:1], held=dict.fromkeys(names, 0.0))


def swing() -> st.Family:
    system = st.System.from_function(
        lambda x, p: [x[1], -p[0] * np.sin(x[0]) - p[1] * x[1] + p[2]],
        name="swing",
        states=("q", "v"),
        parameters=("g", "c", "T"),
    )
    return st.Family(
        system, "rest", at=("T",), held={"v": 0.0}, unknown={"q": 0.1}, equations=("v",)
    )


# --- along an axis ---


def test_a_flutter_boundary_is_found_and_called_by_floats() -> None:
    with pytest.warns(st.StabilityWarning, match="by floats, not proved"):
        found = st.boundaries(swing(), axis=("c", -1, 1, 20), at=0.5, g=9.81)
    [edge] = found
    assert abs(edge.value) <= edge.error < 1e-10
    assert edge.frequency == pytest.approx((9.81**2 - 0.25) ** 0.25, rel=1e-9)
    assert (edge.crossing.word, edge.stable_below, edge.good.word) == ("flutter", False, "stable")
    assert edge.evidence is found.evidence is Evidence.BY_FLOATS
    assert edge.words().endswith(", by floats, not proved")
    assert not found.complete
    assert found.throughout is None
    assert found.how.startswith("by floats, not proved")
    assert "error by floats" in found.to_csv().splitlines()[0]
    assert "arb" not in found.citation


def test_a_proved_boundary_says_so() -> None:
    [edge] = st.boundaries("rolling", axis=("at", 1, 2, 9), contact=st.Viscous(0.3))
    assert edge.evidence is Evidence.PROVED
    assert "floats" not in edge.words()


@quiet
def test_every_crossing_is_counted_on_both_sides() -> None:
    """Eigenvalues a - 0.31, a - 0.37 between two points of the scan, and a pair at a = 0.8."""

    def rates(x: Any, p: Any) -> Any:
        a = p[0]
        pair = (a - 0.8) * x[2] - 2 * x[3], 2 * x[2] + (a - 0.8) * x[3]
        return np.array([(a - 0.31) * x[0], (a - 0.37) * x[1] + x[0] ** 2, *pair])

    family = at_origin(rates, "x y z w", "a")
    found = st.boundaries(family, axis=("a", 0, 1, 5), every=True)
    assert [c.value for c in found] == pytest.approx([0.31, 0.37, 0.8], abs=1e-10)
    assert [(c.unstable_below, c.unstable_above) for c in found] == [(0, 1), (1, 2), (2, 4)]
    assert [c.frequencies for c in found] == [(0.0,), (0.0,), (pytest.approx(2.0),)]
    assert [c.crossing.word for c in found] == ["static", "static", "flutter"]
    assert all(abs(c.value - v) <= c.error for c, v in zip(found, (0.31, 0.37, 0.8), strict=True))
    [edge] = st.boundaries(family, axis=("a", 0, 1, 5))
    assert edge.value == pytest.approx(0.31)


@quiet
@pytest.mark.parametrize(
    ("function", "said"),
    [
        (lambda x, p: [-x[0] if p[0] < 0.3 else x[0]], "jump"),
        (lambda x, p: [-x[0] / (p[0] - 0.3)], "jump"),
        (lambda x, p: [p[0] * 0 * x[0]], "within its estimated error"),
        (lambda x, p: [-((p[0] - 0.5) ** 2) * x[0]], "within its estimated error"),
    ],
    ids=["switch", "pole", "nothing", "touching"],
)
def test_what_floats_do_not_show_stays_open(function: Any, said: str) -> None:
    found = st.boundaries(at_origin(function, parameters="a"), axis=("a", 0, 1, 11))
    assert not found.points
    assert said in found.unresolved[-1].reason
    assert "by floats" in found.unresolved[-1].reason


@quiet
def test_a_sign_within_the_estimated_error_is_no_verdict() -> None:
    """The true boundary a = 0.5 is there, but rounding hides growth rates of 1e-15."""
    family = at_origin(lambda x, p: [x[1], -np.sin(x[0]) - 1e-15 * (p[0] - 0.5) * x[1]], "x y", "a")
    for every in (False, True):
        found = st.boundaries(family, axis=("a", 0, 1, 8), every=every)
        assert not found.points
        assert "within its estimated error" in found.unresolved[-1].reason


@quiet
def test_a_part_without_members_is_named() -> None:
    system = st.System.from_function(
        lambda x, p: [p[0] ** 2 - 0.25 - x[0] ** 2], name="gap", states=("x",), parameters=("a",)
    )
    family = st.Family(system, "upper", at=("a",), unknown={"x": 1.0}, equations=("x",))
    found = st.boundaries(family, axis=("a", -1, 1, 21))
    part = found.unresolved[1]
    assert part.low == pytest.approx(-0.6)
    assert part.high == pytest.approx(0.6)
    assert (
        "no member is found here: upper has no member that Newton's method reaches" in part.reason
    )


# --- against proofs ---


def twins(seed: int) -> tuple[st.Family, st.Family, Any, float]:
    """One random system, as graph and function, with a planted member and the a of its boundary."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    z, p = ca.SX.sym("z", n), ca.SX.sym("p", 2)
    state, value = rng.uniform(-1, 1, n).round(3), rng.uniform(-0.5, 0.5, 2).round(3)
    pick = [ca.sin, ca.exp, ca.tanh, lambda s: s**3, ca.cos]
    rows = []
    for _ in range(n):
        row: Any = float(rng.uniform(-0.3, 0.3)) * p[1]
        for i in range(n):
            row += float(rng.uniform(-2, 2)) * z[i] * (1 + float(rng.uniform(-1, 1)) * p[1])
        for _ in range(3):
            i, j = rng.integers(0, n, 2)
            row += float(rng.uniform(-1, 1)) * pick[int(rng.integers(5))](z[i]) * z[j]
        rows.append(row)
    rhs = ca.vertcat(*rows)
    rhs -= ca.Function("rhs", [z, p], [rhs])(state, value)
    slopes = np.array(ca.Function("s", [z, p], [ca.jacobian(rhs, z)])(state, value))
    lead, turn = float(np.linalg.eigvals(slopes).real.max()), float(rng.choice([-2, 2]))
    edge = float(value[0]) + round(float(rng.uniform(-0.05, 0.05)), 3)
    rhs += (turn * (p[0] - edge) - lead) * (z - state)
    names = tuple(f"z{i}" for i in range(n))
    graph = st.System("random", z, p, rhs, states=names, parameters=("a", "b"))
    f = ca.Function("f", [z, p], [rhs])
    function = st.System.from_function(
        lambda x, q: np.array(f(x, q)).ravel(), name="random", states=names, parameters=("a", "b")
    )
    guess = dict(zip(names, state, strict=True))
    proved = graph.steady("a", guess={**guess, "a": value[0], "b": value[1]})
    family = st.Family(function, "m", at=("a",), unknown=guess, equations=names)
    return proved, family, value, edge


@quiet
@pytest.mark.few(4)
@pytest.mark.parametrize("seed", range(50))
def test_floats_never_contradict_proofs(seed: int) -> None:
    proved, family, (a, b), planted = twins(seed)
    x, y = ("a", a - 0.1, a + 0.1, 5), ("b", b - 0.1, b + 0.1, 3)
    first, second = (st.stability_map(f, x=x, y=y, boundaries=False) for f in (proved, family))
    found = st.boundaries(family, axis=(*x[:3], 9), b=b)
    assert min(abs(e.value - planted) - e.error for e in found) <= 1e-13
    decided = (first.verdict.values % 4 != 0) & (second.verdict.values % 4 != 0)
    for i, j in np.argwhere(decided):
        numbers = [first.a.values[j]], [first.b.values[i]]
        if np.allclose(proved.member(*numbers), family.member(*numbers), atol=1e-6):
            assert first.verdict.values[i, j] == second.verdict.values[i, j]
    try:
        edges = st.boundaries(proved, axis=(*x[:3], 9), b=b)
    except st.StabilityError as error:  # a graph's members are followed, here up to a branch point
        assert "stopped at a transcritical point" in str(error)
        return
    if edges.complete and len(found.unresolved) == 1:
        assert len(found) == len(edges)
        for one, other in zip(found, edges, strict=True):
            assert abs(one.value - other.value) <= one.error + other.error
            assert (one.crossing, one.stable_below) == (other.crossing, other.stable_below)


# --- maps ---


def circle(x: Any, p: Any) -> list[Any]:
    return [(p[0] ** 2 + p[1] ** 2 - 1) * x[0], -x[1]]


def test_a_map_by_floats_has_the_circle_and_says_what_it_rests_on() -> None:
    family = at_origin(circle, "x y")
    m = st.stability_map(family, x=("a", -1.5, 1.5, 13), y=("b", -1.5, 1.5, 13), unstable=True)
    growth = m.a.values**2 + m.b.values[:, None] ** 2 - 1
    codes = np.where(growth == 0, 0, np.where(growth < 0, 1, 2))
    assert (m.verdict.values == codes).all()
    assert (codes == 0).sum() == 4
    assert (np.abs(m.abscissa.values - np.maximum(growth, -1)) <= m.abscissa_error.values).all()
    assert (m.unstable.values == np.choose(codes, [-1, 0, 1])).all()
    points = m.boundary_a.values, m.boundary_b.values
    off = np.abs(np.hypot(*points) - 1)
    assert len(off) > 20
    assert (off <= 2 * m.boundary_error.values).all()
    assert m.boundary_error.values.max() < 1e-9
    assert m.attrs["evidence"] == Evidence.BY_FLOATS.value
    for words in (
        m.attrs["method"],
        m.attrs["tolerances"],
        m.verdict.attrs["long_name"],
        m.unstable.attrs["comment"],
        m.boundary_error.attrs["long_name"],
    ):
        assert "by floats" in words
    assert "estimated" in m.abscissa_error.attrs["long_name"]
    texts = st.plot_map(m).findobj(match=Text)
    assert any("by floats, not proved" in text.get_text() for text in texts)


def test_a_cell_at_a_kink_is_undecided_and_one_without_a_member_is_blank() -> None:
    def rates(x: Any, p: Any) -> list[Any]:
        return [p[0] - x[0] ** 2, -x[1] - (abs(x[1]) if p[1] > 0 else 0)]

    system = st.System.from_function(rates, name="f", states=("x", "y"), parameters=("a", "b"))
    family = st.Family(
        system, "m", at=("a",), held={"y": 0.0}, unknown={"x": 1.0}, equations=("x",)
    )
    m = st.stability_map(family, x=("a", -1, 1, 2), y=("b", -1, 1, 2), boundaries=False)
    assert m.verdict.values.tolist() == [[4, 1], [4, 0]]
    assert np.isnan(m.abscissa.values[1, 1])


@pytest.mark.parametrize("more", [{"certify": True}, {"points": True}, {"checkpoint": "unused"}])
def test_what_a_map_by_floats_does_not_have_is_refused(more: dict[str, Any]) -> None:
    family = at_origin(circle, "x y")
    with pytest.raises(st.StabilityError, match="simulate by floats, or write the equations in"):
        st.stability_map(family, x=("a", 0, 1, 2), y=("b", 0, 1, 2), **more)


def test_sheets_are_not_counted_by_floats() -> None:
    with pytest.raises(st.StabilityError, match="simulate by floats, or write the equations in"):
        st.stability_map(swing(), x=("c", 0, 1, 2), y=("T", 0, 1, 2), g=9.0, box={"q": (-1, 1)})


def test_maps_by_floats_run_on_threads_and_are_stored(tmp_path: Any) -> None:
    family, axes = at_origin(circle, "x y"), {"x": ("a", 0, 2, 5), "y": ("b", 0, 2, 4)}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        one, two = (st.stability_map(family, workers=n, **axes) for n in (1, 2))
    assert (one.abscissa.values == two.abscissa.values).all()
    st.write_map(one, tmp_path / "m.nc")
    assert st.read_map(tmp_path / "m.nc").attrs["evidence"] == Evidence.BY_FLOATS.value
