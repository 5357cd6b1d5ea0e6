"""Families of which parameters are solved for: folds by a state, trims, and what refuses them."""

from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.base.errors import NameUnknownError, ParameterError


def system(name: str, states: str, parameters: str, rates: Any) -> st.System:
    names = states.split(), parameters.split()
    x, p = (ca.SX.sym(n, len(some)) for n, some in zip("xp", names, strict=True))
    rhs = ca.vertcat(*rates(*ca.vertsplit(x), *ca.vertsplit(p)))
    return st.System(name, x, p, rhs, states=tuple(names[0]), parameters=tuple(names[1]))


def cubic() -> st.Family:
    """The rate is mu + lam x - x³: the parameter mu turns at x = ±√(lam/3), the state does not."""
    model = system("cubic", "x", "mu lam", lambda x, mu, lam: [mu + lam * x - x**3])
    return st.Family(model, "rest", at=("x",), unknown={"mu": 0.0}, equations=("x",))


def reaction() -> st.System:
    def rates(u: Any, w: Any, p: Any, heat: Any, loss: Any) -> list[Any]:
        made = p * (1 - u) * ca.exp(w)
        return [-u + made, -w + heat * made - loss * w]

    return system("reaction", "u w", "p heat loss", rates)


def car() -> st.System:
    return system(
        "car", "place v", "thrust drag", lambda _, v, thrust, drag: [v, thrust - drag * v * v]
    )


def brusselator() -> st.System:
    def rates(x: Any, y: Any, a: Any, b: Any) -> list[Any]:
        return [a - (b + 1) * x + x**2 * y, b * x - x**2 * y]

    return system("brusselator", "x y", "a b", rates)


def test_both_folds_of_a_cubic_are_crossings_along_its_state() -> None:
    found = st.boundaries(cubic(), axis=("x", -1.5, 1.5, 40), lam=1.0, every=True)
    assert found.complete
    assert [c.value for c in found] == pytest.approx([-(3**-0.5), 3**-0.5], abs=1e-15)
    assert [(c.crossing.word, c.unstable_below, c.unstable_above) for c in found] == [
        ("static", 0, 1),
        ("static", 1, 0),
    ]
    assert cubic().member([0.5], [1.0]).tolist() == [0.5]


def test_a_map_over_the_state_has_the_curve_of_folds() -> None:
    found = st.stability_map(cubic(), x=("x", -1, 1, 40), y=("lam", 0.1, 2, 30))
    x, lam = found.boundary_x.values, found.boundary_lam.values
    assert found.attrs["boundary_unresolved"] == 0 and len(x) > 60
    assert np.abs(3 * x**2 - lam).max() < 1e-14
    stable = 3 * found.x**2 > found.lam
    assert ((found.verdict == 1) == stable.transpose(*found.verdict.dims)).all()


def test_printed_folds_of_a_reaction_are_found_by_a_state() -> None:
    """AUTO-07p, demo ab: folds at p = .1057390 and .08893185, Hopf point at .1308998."""
    family = st.Family(
        reaction(), "rest", at=("w",), unknown={"u": 0.3, "p": 0.1}, equations=("u", "w")
    )
    known = {"heat": 14.0, "loss": 2.0}
    points = st.boundaries(family, axis=("w", 1.2, 4.3, 20), every=True, **known)
    members = st.spectrum(family, at=[c.value for c in points], **known)
    assert [c.crossing.word for c in points] == ["static", "static", "flutter"]
    assert members.values["p"] == pytest.approx([0.1057390, 0.08893185, 0.1308998], rel=2e-6)
    assert points.complete


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
def test_crossings_far_from_a_pole_are_listed_where_pieces_near_it_stay_open() -> None:
    """As w → 14/3 the reaction needs p → ∞: the budget of pieces ends there, and there alone."""
    family = st.Family(
        reaction(), "rest", at=("w",), unknown={"u": 0.3, "p": 0.1}, equations=("u", "w")
    )
    points = st.boundaries(family, axis=("w", 0.05, 4.6, 60), every=True, heat=14.0, loss=2.0)
    assert [c.crossing.word for c in points] == ["static", "static", "flutter"]
    assert not points.complete and min(u.low for u in points.unresolved) > 4.5


def test_a_trim_has_its_thrust_and_its_spectrum() -> None:
    family = car().steady("v", unknown="thrust", guess={"v": 2.0, "thrust": 1.0, "drag": 0.5})
    assert family.left_out == ("place",) and family.trimmed == ("thrust",)
    found = st.spectrum(family, at=np.array([1.0, 3.0]), drag=0.5, certify=True)
    assert found.values["thrust"].tolist() == [0.5, 4.5]
    assert found.abscissa.tolist() == [-1.0, -3.0] and found.certified.all()
    assert found.structural_zeros == 1  # of the place alone: no other speed has this thrust
    assert "thrust" in found.to_pandas() and found.to_xarray().thrust.values.tolist() == [0.5, 4.5]
    held = car().steady("drag", held={"v": 3.0}, unknown="thrust", guess={"thrust": 1, "drag": 1})
    assert st.spectrum(held, at=2.0).values["thrust"] == pytest.approx(18.0, abs=1e-13)


def test_cycles_are_born_as_along_the_parameter_itself() -> None:
    """The equilibrium is x = a, y = b/a: one point, one coefficient."""
    model, a = brusselator(), 1.3
    by_b = model.steady("b", guess={"x": a, "y": 2.0, "a": a, "b": 2.6})
    by_y = model.steady("y", unknown="b", guess={"x": a, "y": 2.0, "a": a, "b": 2.6})
    [plain] = st.hopf(by_b, axis=("b", 2.0, 3.5, 20), a=a)
    [trim] = st.hopf(by_y, axis=("y", 2.0 / a, 3.5 / a, 20), a=a)
    assert trim.at == pytest.approx((1 + a * a) / a, abs=1e-14)
    assert trim.coefficient == pytest.approx(plain.coefficient, rel=1e-13)
    assert trim.kind is plain.kind and trim.stable_below == plain.stable_below


def test_random_trims_have_the_eigenvalues_of_the_jacobian_alone() -> None:
    """The parameter that is solved for is fixed where a member is disturbed."""
    rng = np.random.default_rng(8)
    for _ in range(20):
        c = rng.normal(size=(3, 6))
        rest = -c @ [0.2, 0.1, -0.1, 0.02, -0.01, -0.02] - 0.3

        def rates(x: Any, y: Any, z: Any, load: Any, c: Any = c, rest: Any = rest) -> list[Any]:
            terms = ca.vertcat(x, y, z, x * y, y * z, x * z)
            return ca.vertsplit(ca.DM(c) @ terms + ca.DM(rest) + load)

        model = system("random", "x y z", "load", rates)
        guess = {"x": 0.2, "y": 0.1, "z": -0.1, "load": 0.3}
        family = model.steady("x", unknown="load", guess=guess)
        found = st.spectrum(family, at=0.2, certify=True)
        x, y, z = found.states
        slope = c[:, :3] + np.array(
            [[k[3] * y + k[5] * z, k[3] * x + k[4] * z, k[4] * y + k[5] * x] for k in c]
        )
        wanted = np.sort_complex(np.linalg.eigvals(slope))
        assert np.abs(np.sort_complex(found.eigenvalues) - wanted).max() < 1e-9
        assert found.certified and (found.verdict is st.Verdict.STABLE) == (wanted.real.max() < 0)


def test_a_condition_on_what_is_solved_for_ends_the_family() -> None:
    """The thrust drag v² may be at most 3: with drag = 1 there is no member above v = √3."""
    thrust, drag, v = (ca.SX.sym(n) for n in ("thrust", "drag", "v"))
    limit = st.Condition(3 - thrust, "the thrust is {value:g} below its limit")
    limited = st.System(
        "limited",
        v,
        ca.vertcat(thrust, drag),
        thrust - drag * v * v,
        states=("v",),
        parameters=("thrust", "drag"),
        conditions=(limit,),
    )
    family = limited.steady("v", unknown="thrust", guess={"v": 1.0, "thrust": 1.0, "drag": 1.0})
    assert st.boundaries(family, axis=("v", 0.1, 1.7, 9), drag=1.0).complete
    with pytest.raises(st.StabilityError, match="-1.84 below its limit"):
        st.boundaries(family, axis=("v", 0.1, 2.2, 9), drag=1.0)
    found = st.stability_map(family, x=("v", 0.1, 2.2, 40), y=("drag", 0.5, 1, 20))
    none = (found.verdict == 4).transpose("drag", "v").values
    assert (none == (found.drag * found.v**2 > 3).transpose("drag", "v").values).all()


def test_a_locus_is_drawn_along_what_names_the_members() -> None:
    family = car().steady("v", unknown="thrust", guess={"v": 2.0, "thrust": 1.0, "drag": 0.5})
    figure = st.plot_locus(st.spectrum(family, at=np.linspace(1, 3, 9), drag=0.5))
    assert figure.axes


def test_what_cannot_take_a_trim_says_so(tmp_path: Any) -> None:
    family = cubic()
    with pytest.raises(ParameterError, match="solved for mu, and a launch gives it a value"):
        st.simulate(family.system, start={"x": 0.1}, times=1.0, mu=0.0, lam=1.0, families=family)
    with pytest.raises(ParameterError, match="solved for mu; continuation codes"):
        st.export.auto_input(family, tmp_path, free="x", start=0.1, stop=1.0, lam=1.0)
    with pytest.raises(st.StabilityError, match="the page solves for states alone"):
        guess = {"v": 2.0, "thrust": 1.0, "drag": 0.5}
        trim = car().steady("v", unknown="thrust", guess=guess)
        st.explore(trim, out=tmp_path / "page.html", v=2.0, drag=0.5)
    with pytest.raises(ParameterError, match="'mu' of family rest is in at and unknown"):
        st.Family(family.system, "rest", at=("x", "mu"), unknown={"mu": 0.0}, equations=("x",))
    with pytest.raises(NameUnknownError, match="an unknown is 'nu'; known are x, mu, lam"):
        st.Family(family.system, "rest", at=("x",), unknown={"nu": 0.0}, equations=("x",))
    with pytest.raises(NameUnknownError, match="unknown is 'x'; known are mu, lam"):
        family.system.steady("x", unknown="x", guess={"x": 0.0, "mu": 0.0, "lam": 1.0})
    with pytest.raises(NameUnknownError, match="known for rest are x, lam"):
        st.boundaries(family, axis=("mu", -1, 1, 9), at=0.1, lam=1.0)
