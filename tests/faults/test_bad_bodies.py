"""Bad bodies of revolution, resistances and drifts: one sentence with the value and the remedy."""

import dataclasses
import math
from collections.abc import Callable, Iterator
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.bodies.resistance import Resistance

TOP = st.EccentricSphere(0.1)
ROLL = st.RollingResistance(0.01)


def body(height: Any = lambda _, a: 1 + 0 * a, **changes: Any) -> st.Body:
    numbers: dict[str, Any] = {"axial": 0.4, "transverse": 0.4, "shape": {"a": 0.1}}
    return st.Body(height, **(numbers | changes))


def solid(r: Any = np.sin, z: Any = lambda u: -np.cos(u), **more: Any) -> st.Body:
    return st.from_profile(lambda u: (r(u), z(u)), **more)


def drift(**changes: Any) -> Any:
    given: dict[str, Any] = {"body": st.Spheroid(0.5), "contact": "viscous", "mu": 0.3}
    return st.slow_flow("rolling", **(given | {"resistance": ROLL} | changes))


def twist(found: Any) -> Resistance:
    """A user's resistance whose moment is something."""

    @dataclasses.dataclass(frozen=True, eq=False)
    class Twist(Resistance):
        q: float
        name, coefficient, unit = "twist", "q", "m s"

        def moment(self, turn: Any, normal: Any, value: Any) -> Any:  # noqa: ARG002
            return found

    return Twist(0.1)


def tumbling(contact: Any = "viscous", at: Any = 1.0, **more: Any) -> Any:
    return st.spectrum("tumbling", at=at, body=TOP, contact=contact, **more)


def retrograde(inner: Any = (0.0,), share: Any = (0.0,), **more: Any) -> Any:
    return st.retrograde_map(inner, share, **more)


def sections(ends: Any) -> Any:
    return st.boundaries("tumbling", axis=("offset", *ends, 5), at=1.0, body=TOP, contact="rough")


def launched(**more: Any) -> Any:
    given: dict[str, Any] = {"x": ("theta", 0.5, 1, 2), "y": ("omega3", 1, 2, 2), "horizon": 0.5}
    return st.basins(contact="rough", **(given | more))


CASES: list[tuple[Callable[[], Any], str]] = [
    (lambda: body(limits={"b": (0, 1)}), "limits names 'b'; numbers of the shape are a"),
    (lambda: body(limits={"a": 3}), "the limit of a is 3; give two numbers (low, high)"),
    (lambda: body(limits={"a": (0, "x")}), "the limit of a is (0, 'x'); give two numbers"),
    (lambda: body(limits={"a": (1, 0)}), "the limit of a is (1, 0); give two numbers"),
    (lambda: body(limits=5), "limits is 5; give pairs (low, high) by name"),
    (lambda: body(between=None), "between is None; give two angles in rising order"),
    (lambda: body(between=(0, 1, 2)), "between is (0, 1, 2); give two angles"),
    (lambda: body(between=(0, 4)), "between is (0, 4); give two angles in rising order between 0"),
    (lambda: body(error="x"), "error is 'x'; a real number is needed"),
    (lambda: body(error=-1), "error is -1; it must not be negative"),
    (lambda: body(name=3), "name of the body is 3; give a string"),
    (lambda: body(name=""), "name of the body is ''; give 1 to 100 printable characters"),
    (lambda: body(5), "height is 5; give a function of theta, a"),
    (lambda: body(lambda theta: theta), "'a'); give a function of theta, a"),
    (lambda: body(lambda theta, a: [theta, a]), "one expression in theta, a is needed"),
    (lambda: body(axial=lambda: 1), "'a'); give a function of a"),
    (lambda: TOP.height_at("x"), "theta is 'x'; a real number is needed"),
    (lambda: TOP.height_at(1.0, 3), "slope is 3; at most 2 are allowed"),
    (lambda: TOP.height_at(1.0, None), "slope is None; a whole number"),  # type: ignore[arg-type]
    (lambda: TOP.family("vertical", "rough", pole=np.ones(2)), "give 0 or 'pi'"),
    (lambda: TOP.family("tumbling", st.Coulomb(0.3)), "contact is coulomb, which has no linear"),
    (
        lambda: TOP.family("tumbling", 3),
        "contact is 3; known are smooth, viscous, linear-viscous, "
        "rough, creep-1, creep-2, creep-3.",
    ),
    (
        lambda: tumbling(st.Coulomb(0.3)),
        "contact is coulomb, which has no linearisation of its "
        "own; known are smooth, viscous, linear-viscous, rough, creep-1, creep-2, creep-3; inside",
    ),
    (lambda: tumbling(st.Viscous(0.3), mu=1), "mu is the viscous law's own number; give it there"),
    (lambda: tumbling(mu=0.3, offset=1), "offset is eccentric sphere's own number"),
    (lambda: tumbling(int), "contact is the class int; known are"),
    (lambda: tumbling(lambda: 0), "contact is a function; give one of Smooth()"),
    (lambda: sections((None, 0.5)), "the low end of the axis offset is None; a real number"),
    (lambda: sections((0.1, math.inf)), "the high end of the axis offset is inf; a finite number"),
    (lambda: st.from_profile(None), "curve is None; give a function of u"),  # type: ignore[arg-type]
    (lambda: st.from_profile(lambda u: np.sin(u)), "with a pair (r, z), such as"),
    (lambda: solid(math.sin), "Python scalars); give a function made of NumPy's"),
    (lambda: solid(lambda u: u * np.nan), "the meridian has no finite point at u = 0"),
    (lambda: solid(lambda u: -np.sin(u)), "a distance from the axis is not negative"),
    (lambda: solid(z=np.cos), "from its lower end, it rises"),
    (lambda: solid(density="x"), "density is 'x'; give a function of r and z, or nothing"),
    (lambda: solid(density=lambda r: r), "2 were given); give a function made of NumPy's"),
    (lambda: solid(density=lambda r, z: None), "density gives None at"),  # noqa: ARG005
    (lambda: solid(density=lambda _, z: z), "density is -1 at r = 8.82e-05 and z = -1"),
    (lambda: solid(density=lambda r, _: 0 * r), "and above 0 somewhere"),
    (lambda: solid(name=7), "name of the body is 7; give a string"),
    (lambda: st.Egg(name="hen"), "'name'; known are mass, gravity, length"),
    (lambda: solid(z=lambda u: -1e300 * np.cos(u)), "do not settle with 1024 nodes"),
    (lambda: Resistance(), "has the coefficient '' and no such field"),
    (
        lambda: tumbling(mu=0.3, resistance=[ROLL, 3]),
        "resistance is [RollingResistance(rho=0.01), 3]; give",
    ),
    (
        lambda: st.simulate(TOP, "rough", {"theta": 1}, 1, resistance=twist(5)),
        "the moment of twist is 5; give a list of three",
    ),
    (lambda: drift(resistance=[ROLL, st.AirTorque(1)]), "resistance names 2 of them; give one"),
    (lambda: drift(resistance=None), "resistance is missing; give one"),
    (lambda: drift(small=3), "small is 3; the small parameter of a body is rho"),
    (lambda: drift().exponent(0, "a"), "near is 'a'; a real number is needed"),
    (lambda: drift().exponent(0, 0), "near is 0, the end itself; give a number to one side"),
    (lambda: drift().rate("a"), "at is 'a'; a real number is needed"),
    (lambda: drift().rate([]), "at is an empty array"),
    (
        lambda: st.slow_flow(TOP.family("tumbling", "rough"), small=np.ones(2)),  # type: ignore[arg-type]
        "parameters of tumbling are offset",
    ),
    (lambda: retrograde("a"), "inner is 'a'; a real number is needed"),
    (lambda: retrograde(share=[2]), "share is [2]; its numbers must lie in [0, 1]"),
    (lambda: retrograde(starts=None), "starts is None; give a list of pairs"),
    (lambda: retrograde(starts=[]), "starts is []; give a list of pairs"),
    (lambda: st.Scene(body=3, contact="rough", start={"theta": 1}), "body is 3; give a stab"),
    (lambda: launched(body=3), "body is 3; give a stability.Body or a stability.Disk"),
    (lambda: launched(body=TOP, family=np.ones(2)), "family is an array of shape (2,)"),
    (lambda: launched(families=np.ones(2)), "families belong to a stability.System"),
]


def sentence(call: Callable[[], Any]) -> str:
    """What a refusal says: one printable sentence without an address; empty for an answer."""
    try:
        call()
    except st.StabilityError as error:
        text = str(error)
        assert text.endswith(".") and text.isprintable(), text
        assert not any(mark in text for mark in ("<class", "<function", " at 0x")), text
        return text
    return ""


@pytest.mark.few(51)
@pytest.mark.parametrize(("call", "words"), CASES, ids=[w[:30] for _, w in CASES])
def test_it_is_refused_in_one_sentence(call: Callable[[], Any], words: str) -> None:
    assert words in sentence(call)


class Loud:
    """A value whose every use is an error."""

    def __repr__(self) -> str:
        raise RuntimeError("no text")

    __array__ = __float__ = __iter__ = __len__ = __repr__


VALUES: list[Any] = [
    None,
    "x",
    "",
    b"x",
    3,
    -1,
    0,
    math.nan,
    math.inf,
    1e300,
    1e-320,
    10**400,
    True,
    1j,
    [],
    (),
    {},
    {"a": 3},
    {1: 1},
    {1},
    (0, 1, 2),
    ("a", "b"),
    (math.nan, 1),
    [[1], [1, 2]],
    object(),
    Loud(),
    int,
    math.sin,
    lambda: 1,
    np.ones(2),
    np.array(["a"]),
    st.Viscous(1.0),
    st.Coulomb(0.3),
    st.Viscous,
    st.Disk(),
    ca.SX.sym("q"),
    "y" * 5000,
    "a\nb",
]


def calls(value: Any) -> Iterator[Callable[[], Any]]:
    """Every constructor with one argument of this value."""
    for name in (
        "height",
        "axial",
        "transverse",
        "mass",
        "length",
        "shape",
        "name",
        "between",
        "limits",
        "error",
    ):
        yield lambda name=name: body(**{name: value})
    named = st.Torus, st.Spheroid, st.EccentricSphere, st.ThickDisk, st.Egg, st.from_profile
    for make in (*named, st.AirTorque, st.RollingResistance, st.PivotingResistance):
        yield lambda make=make: make(value)
    yield lambda: body(limits={"a": (0, value)})
    yield lambda: body(lambda theta, a: value)  # noqa: ARG005
    yield lambda: st.from_profile(lambda _: value)
    yield lambda: solid(lambda _: value)
    yield lambda: solid(density=value)
    yield lambda: solid(density=lambda r, z: value)  # noqa: ARG005
    yield lambda: TOP.height_at(value)
    yield lambda: TOP.height_at(1.0, value)
    yield lambda: TOP.family("vertical", value, pole=0)
    yield lambda: TOP.family("vertical", "rough", pole=value)
    yield lambda: drift(resistance=value)
    yield lambda: drift(small=value)
    yield lambda: st.retrograde_map(value, [0.0], starts=[(80.0, value)])
    yield lambda: st.retrograde_map([0.0], [0.0], starts=value)
    yield lambda: launched(body=value)
    yield lambda: st.Scene(body=value, contact="rough", start={"theta": 1}, horizon=1.0)


@pytest.mark.few(17)
@pytest.mark.parametrize("value", VALUES, ids=range(len(VALUES)))
def test_any_value_gets_an_answer_or_one_sentence(value: Any) -> None:
    said = [sentence(call) for call in calls(value)]
    assert sum(map(bool, said)) > 8  # most arguments refuse it


@pytest.mark.long
def test_a_film_of_a_body_with_other_numbers_is_refused(tmp_path: Any) -> None:
    run = st.simulate(TOP, "rough", {"theta": 1.0}, np.linspace(0, 0.5, 9), pose=True)
    for other, words in (
        (st.EccentricSphere(0.2), "offset of the body is 0.2 and that of the dataset 0.1"),
        (
            st.EccentricSphere(0.1, mass=1, gravity=1, length=2),
            "length of the body is 2 and that of the dataset 1",
        ),
        (st.EccentricSphere([0.1, 0.2]), "give the body with the numbers of the one launch"),
    ):
        with pytest.raises(st.StabilityError) as error:
            st.animate(run, tmp_path / "film.html", body=other)
        assert words in str(error.value)
    assert st.animate(run, tmp_path / "film.html", body=TOP).is_file()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: body(lambda t, a: 1 + a * ca.sign(ca.cos(t))), "height uses sign"),
        (lambda: TOP.height_at(math.nan), "theta is nan; a finite number is needed"),
        (lambda: TOP.height_at([1.0, math.inf]), "theta is inf"),
        (lambda: st.Egg(0.2, aspect=1e308), r"aspect is 1e\+308; it must lie in"),
        (
            lambda: st.launch("rolling", at=1.0, body=3),  # type: ignore[arg-type]
            "body is 3; give a stability.Body or a stability.Disk",
        ),
        (
            lambda: st.launch("vertical", at=1.0, body=TOP, pole=np.array([0, 1])),
            "pole is an array",
        ),
    ],
)
def test_a_height_or_a_pole_that_is_none(call: Callable[[], Any], said: str) -> None:
    with pytest.raises(st.StabilityError, match=said):
        call()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"quantities": {"x": "rad"}}, "quantity x is 'rad'; give a Quantity"),
        ({"approximation": 3}, "approximation is 3; give a text"),
        ({"units": {"x": None}}, "the unit of x is None; give a text"),
    ],
)
def test_words_of_a_system_are_texts(words: dict[str, Any], said: str) -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    with pytest.raises(st.StabilityError, match=said):
        st.System("s", x, p, -p * x, states=("x",), parameters=("p",), **words)


@pytest.mark.parametrize("name", ["x", "p", "rates"])
def test_an_observable_may_have_a_name_of_the_graphs_ports(name: str) -> None:
    y, p = ca.SX.sym("y"), ca.SX.sym("k")
    system = st.System(
        "s", y, p, -p * y, states=("y",), parameters=("k",), observables={name: 2 * y}
    )
    run = st.simulate(system, {"k": 1.0}, {"y": 1.0}, [0.0, 1.0])
    assert float(run[name][-1]) == pytest.approx(2 * math.exp(-1), abs=1e-7)
