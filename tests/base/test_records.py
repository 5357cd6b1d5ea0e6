"""Public records travel: pickle, deepcopy, equality and hash, alone and through a process pool."""

import copy
import inspect
import multiprocessing
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache, partial
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

import stability as st
from stability.base.lazy import HOMES
from stability.base.types import content
from stability.bodies.model import system_model


@dataclass(frozen=True, eq=False)
class Weakening(st.Contact):
    nu: float
    name = "weakening"
    parameters = (st.Parameter("nu", "s/m"),)

    def force(self, slip: Any, normal: Any, nu: Any) -> Any:
        share = nu * normal / (1 + slip[0] ** 2 + slip[1] ** 2)
        return [-share * slip[0], -share * slip[1]]


class Damped(st.ExactPolynomial):
    def coefficients(self, values: Any, algebra: Any) -> Any:  # noqa: ARG002
        return [[values["g"], values["d"], 1]]


def pendulum(damping: float = 0.1) -> st.System:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    return st.System(
        "pendulum",
        x,
        p,
        ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - damping * p[1] * x[1]),
        states=("angle", "rate"),
        parameters=("g", "d"),
        observables={"height": -ca.cos(x[0])},
        conditions=(st.Condition(p[0], "g is {value:g}, which must be positive"),),
        units={"angle": "rad", "rate": "rad/s"},
    )


def hanging(damping: float = 0.1) -> st.Family:
    held = {"angle": 0.0, "rate": 0.0}
    exact = Damped() if damping == 1 else None
    return st.Family(pendulum(damping), "hanging", at=("g",), held=held, exact=exact)


def fork() -> st.Family:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    system = st.System("pitchfork", x, p, p * x - x**3, states=("x",), parameters=("p",))
    return st.Family(system, "rest", at=("p",), unknown={"x": 0.0}, equations=("x",))


def fold(points: int) -> st.Branch:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    system = st.System("fold", x, p, p - x**2, states=("x",), parameters=("p",))
    upper = system.steady("p", guess={"x": 1.5, "p": 2.0}, name="upper")
    return st.branch(upper, 2.0, -1.0, [], points=points)


def drum(x: Any, p: Any) -> Any:
    return x, p


def raise_(states: Any, p: Any) -> Any:  # noqa: ARG001
    return states


def reduced(name: str) -> st.ReducedModel:
    return st.ReducedModel(name, pendulum(), drum, raise_)


def scene(horizon: float) -> st.Scene:
    start = {"theta": 1.5706, "omega3": 1.2}
    return st.Scene(start=start, contact=st.Viscous(300.0), horizon=horizon, tolerance=1e-6)


def plane(shift: float) -> Any:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(x[1], (p[0] - shift) * x[0] + p[1] * x[1] - x[0] ** 3)
    system = st.System("takens", x, p, rates, states=("q", "v"), parameters=("a", "b"))
    rest = st.Family(system, "rest", at=("a",), held={"q": 0.0, "v": 0.0})
    axes = {"x": ("a", -1.0, 1.0, 5), "y": ("b", -1.0, 1.0, 5)}
    return st.codimension_two(rest, **axes, curves=True)


NEARBY = (0.3, 0.4)
MAKERS: dict[str, Callable[[float], Any]] = {
    "Table": lambda v: st.table("drift", k=0.25, mu=v),
    "Disk": lambda v: st.Disk(mass=[v, 1.0], radius=2.0, gravity=1.0),
    "Body": lambda v: st.Body(
        lambda t, e: 1 - e * ca.cos(t), axial=0.4, transverse=0.4, shape={"e": v}
    ),
    "Resistance": lambda v: st.AirTorque(v),
    **{n: getattr(st, n) for n in ("RollingResistance", "PivotingResistance", "AirTorque")},
    "SlowFlow": lambda v: st.slow_flow(
        "rolling", body=st.Torus(v), contact=st.Viscous(0.3), resistance=st.AirTorque(0.1)
    ),
    "PainleveLimit": lambda v: st.painleve_limit(st.Torus(v)),
    "Uniform": lambda v: st.Uniform(v, v + 1),
    "LogUniform": lambda v: st.LogUniform(v, v + 1),
    "Normal": lambda v: st.Normal(v, 1),
    "Ball": lambda v: st.Ball({"theta": v}, {"theta": 0.1}),
    "Contact": Weakening,
    "Smooth": lambda v: st.Smooth() if v < 0.35 else st.Rough(),
    "Rough": lambda v: st.Rough() if v < 0.35 else st.Smooth(),
    **{n: getattr(st, n) for n in ("Viscous", "LinearViscous", "Coulomb", "Creep")},
    "RegularisedCoulomb": lambda v: st.RegularisedCoulomb(0.3, v),
    "Parameter": lambda v: st.Parameter("mu", f"{v} s/m"),
    "System": pendulum,
    "Condition": lambda v: st.Condition(ca.SX.sym("g") - v, "g is {value}"),
    "Family": hanging,
    "Equilibria": lambda v: pendulum(v).equilibria({"angle": (-1, v), "rate": (-1, 1)}, g=9, d=1),
    "Branch": lambda v: fold(round(10 * v)),
    "Fold": lambda v: fold(round(10 * v)).folds[0] if v < 0.35 else st.Fold(v, np.ones(2), 0, True),
    "BranchPoint": lambda v: st.branch(fork(), -v, 1, [], points=7).branch_points[0],
    "Spectrum": lambda v: st.spectrum("rolling", at=[1.8, v], contact=st.Viscous(0.3)),
    "BoundaryPoint": lambda v: edges(v)[0],
    "AxisCrossing": lambda v: every(v)[0],
    "Crossings": lambda v: every(v),
    "Boundaries": lambda v: edges(v),
    "Unresolved": lambda v: st.Unresolved(v, v, "no reason"),
    "Exact": lambda v: st.exact_polynomial("rolling" if v < 0.35 else "spinning", "viscous"),
    "ExactPolynomial": lambda v: _zeros(round(10 * v)),
    "Conditions": lambda v: st.conditions(hanging(v), positive=("g",)),
    "Drift": lambda v: st.drift(at=1.5, tilt=v / 10, contact=st.Viscous(1.0)),
    "HopfPoint": lambda v: st.hopf("spinning", contact=st.Viscous(v + 0.5))[0],
    "CycleBirth": lambda v: st.CycleBirth(1, 0, st.Onset.UNDECIDED, True, *[float("nan")] * 5, v),
    "CodimensionTwo": plane,
    "DegeneratePoint": lambda v: plane(v)[0],
    "CurveOfZeros": lambda v: plane(v).curves[0],
    "Scene": scene,
    "Answer": lambda v: scene(100 * v).answer(),
    "Rung": lambda v: scene(100 * v).answer().rungs[0],
    "Citation": lambda v: st.citation(None if v < 0.35 else edges(v)),
    "ReducedModel": lambda v: reduced(f"model {v}"),
}


def _zeros(count: int) -> Damped:
    polynomial = Damped()
    polynomial.zeros = count
    return polynomial


def edges(v: float) -> st.Boundaries:
    disk = st.Disk(k=v)
    return st.boundaries("rolling", axis=("at", 0.1, 5, 9), disk=disk, contact=st.Viscous(1))


def every(v: float) -> st.results.Crossings:
    disk = st.Disk(k=v)
    return st.boundaries(
        "rolling", axis=("at", 0.1, 5, 9), disk=disk, contact=st.Viscous(1), every=True
    )


CLASSES = sorted(n for n in HOMES if inspect.isclass(getattr(st, n)))
RECORDS = [n for n in CLASSES if not issubclass(getattr(st, n), (Enum, Exception))]


@cache
def made(name: str, number: float, turn: int = 0) -> Any:  # noqa: ARG001
    return MAKERS[name](number)


def travelled(value: Any) -> list[Any]:
    copies = [pickle.loads(pickle.dumps(value, p)) for p in (2, pickle.HIGHEST_PROTOCOL)]
    return [*copies, copy.deepcopy(value), copy.copy(value)]


@pytest.mark.parametrize("name", RECORDS)
def test_a_record_travels_and_equals_what_was_made_alike(name: str) -> None:
    one, alike, other = made(name, 0.3), made(name, 0.3, 1), made(name, 0.4)
    assert isinstance(one, getattr(st, name))
    for back in [alike, *travelled(one)]:
        assert back == one and hash(back) == hash(one) and type(back) is type(one)
        assert back != other and one != other and back != "something else"
    assert len({one, alike, other}) == 2


@pytest.mark.parametrize("name", [n for n in CLASSES if n not in RECORDS])
def test_members_and_errors_travel(name: str) -> None:
    kind = getattr(st, name)
    for one in kind if issubclass(kind, Enum) else [kind("a sentence")]:
        for back in travelled(one):
            assert type(back) is kind and str(back) == str(one)
            assert not isinstance(one, Enum) or back is one


numbers = some.floats(1e-3, 1e3)
arrays = some.one_of(numbers, some.lists(numbers, min_size=2, max_size=2).map(np.array))


@settings(max_examples=30)
@given(arrays, arrays, some.sampled_from(["mass", "radius", "gravity"]))
def test_disks_are_equal_if_and_only_if_their_numbers_are(a: Any, b: Any, name: str) -> None:
    one, other = (st.Disk(**{"mass": 1, "radius": 1, "gravity": 1} | {name: v}) for v in (a, b))
    same = np.shape(a) == np.shape(b) and bool(np.all(a == b))
    assert (one == other) is same and (hash(one) == hash(other) or not same)
    assert all(back == one and hash(back) == hash(one) for back in travelled(one))


LAWS = (st.Viscous, st.Coulomb, *(partial(st.Creep, order=n) for n in (1, 2, 3)))


def test_each_order_of_creep_is_a_law_of_its_own() -> None:
    orders = [st.Creep(0.3, order=n) for n in (1, 2, 3)]
    assert st.Creep(0.3) == orders[0] and len({*orders}) == 3
    assert [law.name for law in orders] == ["creep-1", "creep-2", "creep-3"]
    assert all(isinstance(law, st.Creep) and replace(law, mu=0.3) == law for law in orders)
    for order in (0, 4, 1.5, "2"):
        with pytest.raises(st.StabilityError, match="order is .*whole number|at most 3"):
            st.Creep(0.3, order=order)  # type: ignore[arg-type]


@settings(max_examples=30)
@given(some.sampled_from(LAWS), arrays, some.booleans())
def test_laws_are_equal_if_and_only_if_class_and_numbers_are(
    law: Any, mu: Any, list_: bool
) -> None:
    one = law(mu)
    assert one == law(np.copy(mu).tolist() if list_ else np.copy(mu))
    assert one != st.LinearViscous(mu) and one != law(np.asarray(mu) * 2)
    assert all(back == one and hash(back) == hash(one) for back in travelled(one))


@pytest.mark.parametrize("examples", [4, pytest.param(25, marks=pytest.mark.long)])
def test_a_spectrum_that_travelled_answers_the_same(examples: int) -> None:
    settings(max_examples=examples, deadline=None)(_answers_the_same)()


@given(some.lists(numbers, min_size=1, max_size=3), numbers, some.booleans())
def _answers_the_same(at: Any, d: float, certify: bool) -> None:
    spectrum = st.spectrum(hanging(), at=at, d=d, certify=certify)
    for back in travelled(spectrum):
        assert back == spectrum and np.array_equal(back.modes.vectors, spectrum.modes.vectors)
        assert content(back.nonlinear) == content(spectrum.nonlinear)
        again = st.spectrum(back.family, at=at, d=d, certify=certify)
        assert np.array_equal(again.eigenvalues, spectrum.eigenvalues)


def test_zero_has_no_sign_and_nan_equals_nan_in_a_record() -> None:
    assert content(np.array([0.0, np.nan])) == content(np.array([-0.0, np.nan]))
    assert content(np.array([0.0])) != content(np.array([False])) != content(np.array([[0.0]]))


# --- systems ---


def test_systems_differ_by_the_last_bit_of_a_number_in_their_graph() -> None:
    assert pendulum(0.1) == pendulum(0.1) != pendulum(np.nextafter(0.1, 1))
    assert pendulum() != pendulum().function


def test_a_system_in_a_collection_keeps_its_symbols_together() -> None:
    """Everything in one pickle that holds one system holds one copy of it."""
    system, family = pickle.loads(
        pickle.dumps(
            (
                one := pendulum(),
                st.Family(one, "hanging", at=("g",), held={"angle": 0.0, "rate": 0.0}),
            )
        )
    )
    assert family.system is system
    rate = ca.Function("f", [system.x, system.p], [system.rhs])([0.5, 0.0], [9.81, 1.0])
    assert np.array_equal(np.array(rate)[:, 0], system.rates([0.5, 0.0], [9.81, 1.0]))


@pytest.mark.parametrize("method", ["dop853", pytest.param("taylor", marks=pytest.mark.long)])
def test_two_equal_systems_move_each_by_its_own_symbols(method: str) -> None:
    """Caches compare systems by identity where they hold CasADi's symbols."""
    start = {"angle": 1.0, "rate": 0.0}
    one, other = pendulum(), pendulum()
    assert system_model(one).system is one and system_model(other).system is other
    runs = [st.simulate(s, {"g": 1.0, "d": 2.0}, start, 1.0, method=method) for s in (one, other)]
    assert runs[0].angle.identical(runs[1].angle)


# --- other processes ---


def test_a_process_pool_takes_families_and_returns_spectra() -> None:
    asked: list[Any] = [(hanging(), {"d": 1.0}), ("rolling", {"contact": st.Viscous(0.3)})]
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        for family, other in asked:
            back = pool.submit(st.spectrum, family, at=1.8, **other).result()
            here = st.spectrum(family, at=1.8, **other)
            assert back == here and back.modes.labels == here.modes.labels


# --- words ---


@pytest.mark.parametrize("name", [n for n in CLASSES if issubclass(getattr(st, n), Enum)])
def test_an_enumeration_prints_its_word_and_accepts_a_word_or_a_code(name: str) -> None:
    kind = getattr(st, name)
    for one in kind:
        assert str(one) == f"{one}" == one.word and kind(one.word) is kind(one.name) is one
        assert one.code is None or kind(one.code) is kind(np.int8(one.code)) is one
        assert one == one.word and hash(one) == hash(one.word) and one != "no such word"
        assert (np.array([one, None], dtype=object) == one.word).tolist() == [True, False]
    for wrong in ("no such word", 99, -1, True, None):
        with pytest.raises(st.StabilityError, match=next(iter(kind)).word):
            kind(wrong)


def test_the_codes_are_those_of_a_map() -> None:
    chart = st.stability_map("spinning", x=("at", 1, 4, 7), y=("mu", 0.1, 2, 5))
    words = chart.verdict.attrs["flag_meanings"].split()
    assert [st.Verdict(c).word for c in chart.verdict.attrs["flag_values"]] == words
    kinds = chart.boundary_kind.attrs
    assert [st.Crossing(c).word for c in kinds["flag_values"]] == kinds["flag_meanings"].split()


def test_each_public_name_is_listed_once_and_found_on_the_face() -> None:
    rooms = {"export": st.export, "results": st.results, "statistics": st.statistics}
    assert dir(st) == sorted([*st.__all__, *rooms])
    names = [name for room in (st, *rooms.values()) for name in room.__all__]
    assert sorted(names) == sorted(HOMES) and len(set(names)) == len(names)
    for room in rooms.values():
        assert dir(room) == room.__all__
        for name in room.__all__:
            assert getattr(room, name) is getattr(st, name)
    with pytest.raises(AttributeError, match=r"'stability\.results' has no attribute 'spectrum'"):
        st.results.spectrum  # noqa: B018


def test_modules_of_the_same_folder_do_not_hide_a_name() -> None:
    for path in Path(st.export.__file__).parent.glob("*.py"):
        assert path.stem not in st.export.__all__
