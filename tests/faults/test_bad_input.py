"""Bad input in Python: one sentence with the value and what is accepted."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st

V = st.Viscous


def ask(at: Any = 1.2, contact: Any = None, disk: Any = None, family: Any = "rolling") -> Any:
    return st.spectrum(family, at=at, disk=disk, contact=contact or V(0.3))


def chart(x: Any = ("at", 1, 2, 3), y: Any = ("mu", 0.1, 1, 3), **more: Any) -> Any:
    return st.stability_map("rolling", x=x, y=y, **more)


def fall(**changes: Any) -> Any:
    return st.drift(**({"at": 2.0, "tilt": 0.1, "contact": V(0.5)} | changes))


def land(distance: Any, amplitude: Any = 0.0) -> Any:
    [point] = st.hopf("spinning", contact=V(0.8), points=40)
    return point.landing(distance, amplitude)


def derived(k: Any) -> Any:
    from stability.derivation.formulas import formulas

    return formulas("spinning", "rough", k)


def family() -> st.Family:
    x, p = ca.SX.sym("x"), ca.SX.sym("p", 2)
    system = st.System("s", x, p, p[0] * x - p[1] * x, states=("x",), parameters=("g", "c"))
    return st.Family(system, "rest", at=("g",), held={"x": 0})


CASES: list[tuple[str, Callable[[], Any], str]] = [
    ("drift without at", lambda: fall(at=None), "at is missing"),
    ("drift by a law's name", lambda: fall(contact="viscous"), "mu is missing"),
    ("drift of a tiny tilt", lambda: fall(tilt=1e-300), "leaves double precision"),
    ("drift far out", lambda: fall(at=1e300), "double precision"),
    ("drift of huge friction", lambda: fall(contact=V(1.7e308)), "double precision"),
    ("drift of a thing", lambda: fall(disk=[]), "give a stability.Disk"),
    ("hopf without a law", lambda: st.hopf("spinning", contact=None), "contact is missing"),  # type: ignore[arg-type]
    ("hopf of a list", lambda: st.hopf([], contact=V(1)), "family is []"),  # type: ignore[arg-type]
    ("hopf of many", lambda: st.hopf("spinning", contact=V([1, 2])), "mu is an array"),
    ("hopf by text", lambda: st.hopf("spinning", contact=V(1), points="x"), "points is 'x'"),  # type: ignore[arg-type]
    ("hopf by truth", lambda: st.hopf("spinning", contact=V(1), points=True), "points is True"),
    ("landing of text", lambda: land("x"), "distance is 'x'"),
    ("landing of two", lambda: land([1, 2]), "one number each"),
    ("landing of nothing", lambda: land(0.1, None), "amplitude is None"),
    ("k by zero", lambda: derived(("1/0",)), "give exact numbers in (0, 1/2]"),
    ("k as a word", lambda: derived(["abc"]), "give exact numbers in (0, 1/2]"),
    ("k out of range", lambda: derived(("3/4",)), "k is '3/4'"),
    ("disk is zero", lambda: ask(disk=0), "give a stability.Disk"),
    ("disk is an array", lambda: ask(disk=np.ones((0, 3))), "give a stability.Disk"),
    ("progress is a number", lambda: chart(progress=5), "progress is 5"),
    ("certify a map by 1", lambda: chart(certify=1), "certify is 1"),
    ("levels alone", lambda: chart(levels=5), "levels belongs to certify"),
    ("lean and at", lambda: st.spectrum("tumbling", at=1, lean=1, contact=V(1)), "give one of"),
    ("lean of rolling", lambda: st.spectrum("rolling", lean=1, contact=V(1)), "give at"),
    ("text for at", lambda: ask("a"), "at is 'a'; a real number"),
    ("nan for at", lambda: ask(np.nan), "at is nan; a finite"),
    ("one nan of many", lambda: ask([1.0, np.nan]), "at is nan; a finite"),
    ("truth for at", lambda: ask(True), "at is True; a real number"),
    ("complex at", lambda: ask(1j), "at is 1j; a real number"),
    ("nothing for at", lambda: ask(None), "at is missing"),
    ("empty at", lambda: ask([]), "at is an empty array"),
    ("ragged at", lambda: ask([[1], [1, 2]]), "a real number is needed"),
    ("masked at", lambda: ask(np.ma.masked_array([1.0, 2.0], [0, 1])), "masked entries"),
    ("shapes that do not fit", lambda: ask([1, 2], V([1, 2, 3])), "do not broadcast"),
    ("no family", lambda: ask(family=None), "family is None"),
    ("unknown family", lambda: ask(family="hopping"), "known are rolling"),
    ("contact by name", lambda: ask(contact="viscous"), "give Viscous(mu), or contact='viscous'"),
    ("contact class", lambda: ask(contact=V), "mu is missing; give Viscous(mu)"),
    ("disk by name", lambda: ask(disk="quarter"), "give a stability.Disk"),
    (
        "a name misspelt",
        lambda: st.spectrum("rolling", at=1, contact="viscous", mue=0.3),
        "'mue' is not an argument here; mu is",
    ),
    ("no contact", lambda: st.spectrum("rolling", at=1), "contact is missing"),
    (
        "mu twice",
        lambda: st.spectrum("rolling", at=1, contact=V(1), mu=2),
        "Viscous(mu=1.0); leave mu out",
    ),
    ("certify", lambda: st.spectrum("rolling", at=1, contact=V(1), certify=1), "certify"),
    ("mu zero", lambda: V(0), "Smooth()"),
    ("mu nan", lambda: V([0.1, np.nan]), "mu is nan"),
    ("c negative", lambda: st.LinearViscous(-1), "c is -1"),
    ("k too large", lambda: st.Disk(k=[0.1, 0.7]), "k is 0.7"),
    ("mass text", lambda: st.Disk(mass="heavy"), "mass is 'heavy'"),
    ("hole too large", lambda: st.Disk.annulus(2), "between 0 and the radius"),
    ("unknown disk", lambda: st.Disk.named("penny"), "known are quarter"),
    (
        "scales overflow",
        lambda: st.Disk(mass=1.0, gravity=1e308, radius=1e308),
        "beyond double precision",
    ),
    ("at overflows", lambda: ask(1e300, family="spinning"), "overflow double precision"),
    ("axis is text", lambda: chart(x="at"), "give (name, low, high, n)"),
    ("axis is a number", lambda: chart(x=5), "give (name, low, high, n)"),
    ("axis end is text", lambda: chart(x=("at", "a", 2, 3)), "the low end of the x axis at is 'a'"),
    ("axis end is nothing", lambda: chart(x=("at", None, 2, 3)), "a real number is needed"),
    ("axis that does not move", lambda: chart(x=("at", 1, np.nextafter(1, 2), 5)), "no 5"),
    ("too many cells", lambda: chart(x=("at", 1, 2, 99_999), y=("mu", 1, 2, 99_999)), "at most"),
    ("too long an axis", lambda: chart(x=("at", 1, 2, 10**20)), "at most"),
    ("truth array", lambda: ask([True, False]), "a real number is needed"),
    ("a date", lambda: ask(np.datetime64("2020")), "a real number is needed"),
    ("a huge integer", lambda: ask(10**400), "a real number is needed"),
    ("annulus with k", lambda: st.Disk.annulus(0.5, k=0.3), "leave it out"),
    ("tracked of one", lambda: ask(1.0).tracked(), "as an array"),
    ("overflow, smooth", lambda: ask(1e200, st.Smooth()), "overflow"),
    ("overflow, circling", lambda: ask((1.2, 1e150), st.Rough(), family="circling"), "overflow"),
    (
        "branch to nowhere",
        lambda: st.branch(st.disk_family("tumbling", "viscous"), 1, 0.5, [0.25]),
        "must hold 2 values",
    ),
    (
        "branch of half points",
        lambda: st.branch(st.disk_family("tumbling", "viscous"), 1, 0.5, [0.25, 0.3], points=2.5),
        "whole number",
    ),
    ("branch of a name", lambda: st.branch("tumbling", 1, 0.5, [0.25, 0.3]), "stability.Family"),
    ("axis count is float", lambda: chart(x=("at", 1, 2, 3.0)), "at least 2"),
    ("axis name is number", lambda: chart(x=(1, 1, 2, 3)), "give a string"),
    ("no workers", lambda: chart(workers=0), "workers is 0"),
    ("array in a map", lambda: chart(disk=st.Disk(k=[0.2, 0.3])), "k is an array"),
    ("at as value and axis", lambda: chart(at=1.0), "give it once"),
    ("checkpoint elsewhere", lambda: chart(checkpoint="/nowhere/at/all"), "does not exist"),
    ("not a path", lambda: st.read_map(3), "give a string or a path"),
    ("not a dataset", lambda: st.write_map(3, "x.nc"), "what stability_map returns"),
    ("system of numbers", lambda: st.System("x", 1, 2, 3, states=("a",)), "CasADi SX"),
    (
        "branch of one point",
        lambda: st.branch(st.disk_family("tumbling", "viscous"), 1, 0.5, [0.25, 0.3], points=1),
        "at least 2",
    ),
    (
        "state of wrong length",
        lambda: st.disk_system("viscous").rates([1, 2], [0.25, 0.3]),
        "must hold 6 values",
    ),
    (
        "state with nan",
        lambda: st.disk_system("rough").rates([1, np.nan, 0, 0], [0.25]),
        "NaN or infinite",
    ),
    ("unknown state", lambda: st.disk_system("rough").index("x"), "known are theta"),
    ("a resistance that drives", lambda: st.AirTorque(-1), "drag is -1; it must be 0 or above"),
    ("branch of nothing", lambda: st.branch(family(), 1.0, 2.0), "parameters is empty; give c"),
    ("table of a number", lambda: st.table("drift", kk=0.25), "it takes k, mu, contact, disk and"),
    (
        "a motion as a map",
        lambda: st.plot_map(st.simulate(st.Disk(), V(0.3), {"theta": 1.4}, 0.1)),
        "dataset is a dataset (motion of a disk, viscous contact); give what stability_map",
    ),
    (
        "a file as a folder",
        lambda: st.write_map(chart(), f"{__file__}/a.nc"),
        "test_bad_input.py is a file, and no folder",
    ),
    (
        "rows of a CasADi matrix",
        lambda: st.disk_family("tumbling", "viscous").checked_states(
            np.ones((2, 1)), None, ca.DM([[0.25, 0.3]])
        ),
        "shapes (2, 1), (2, 1), (1, 2)",
    ),
]


@pytest.mark.few(77)
@pytest.mark.parametrize(
    ("call", "sentence"), [c[1:] for c in CASES], ids=[c[0].replace(" ", "-") for c in CASES]
)
def test_it_is_refused_in_one_sentence(call: Callable[[], Any], sentence: str) -> None:
    with pytest.raises(st.StabilityError) as caught:
        call()
    text = str(caught.value)
    assert sentence in text
    assert len(text.splitlines()) == 1
    assert text.endswith(".")
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("family", ["rolling", "spinning", "tumbling"])
@pytest.mark.parametrize("mu", [5e-324, 1e-300, 1e-20, 1e20, 1e155, 1e300])
def test_extreme_friction_is_undecided_or_right_and_never_nan(family: str, mu: float) -> None:
    found = ask(1.2, V(mu), family=family)
    assert not np.isnan(found.eigenvalues).any()
    assert not np.isnan(found.radius).any()
    assert not np.isnan(found.modes.vectors).any()
    if found.verdict is st.Verdict.STABLE:  # at 1.2 all three are unstable but weakly
        assert family == "tumbling"
        assert mu < 1


def test_numbers_of_any_kind_serve_as_expressions_of_a_system() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    words: dict[str, Any] = {"states": ("a", "b"), "parameters": ("p",)}
    rhs = ca.vertcat(x[1], -p * x[0])
    half = st.System("s", x, p, rhs, observables={"e": Fraction(1, 2)}, **words)
    assert half.observe([1.0, 0.0], [2.0])["e"] == 0.5
    with pytest.raises(st.StabilityError, match="mass and forcing belong together"):
        st.System("s", x, p, rhs, mass=ca.SX(1), **words)
    with pytest.raises(st.StabilityError, match="forcing has shape 1 x 1; give 2 x 1"):
        st.System("s", x, p, rhs, mass=ca.SX.eye(2), forcing=ca.SX(1), unknowns=("u", "v"), **words)


def test_a_launch_whose_rate_overflows_is_refused() -> None:
    with pytest.raises(st.StabilityError, match="at of tumbling is 4.94066e-324, where its rate"):
        st.launch("tumbling", at=5e-324, disk=st.Disk())
