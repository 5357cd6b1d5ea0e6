"""Zeros by structure in a Jordan block: motions grow like a power of t, and the verdict says so."""

import random
from fractions import Fraction
from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy as sp
import xarray
from own_systems import system_of
from scipy.linalg import expm

import stability as st
from stability.cli.commands import main
from stability.polynomials.zero_blocks import semisimple
from stability.spectra.deflation import drift_powers
from stability.systems.structure.structural_zeros import structure

HOVER = """
import casadi as ca, stability as st
tilt, rate, v, lift, m, c = (ca.SX.sym(n) for n in ("tilt", "rate", "v", "lift", "m", "c"))
rates = ca.vertcat(rate, 0 * rate, (-lift * ca.sin(tilt) - c * v) / m)
system = st.System("hover", ca.vertcat(tilt, rate, v), ca.vertcat(lift, m, c), rates,
                   states=("tilt", "rate", "v"), parameters=("lift", "m", "c"))
level = st.Family(system, "level", at=("lift",), held={"tilt": 0, "rate": 0, "v": 0})
"""

# every system here is linear, so that no higher orders could decide
GROWS, LINEAR = st.Nonlinear.GROWS, st.Nonlinear.LINEAR


def steady(matrix: Any, at: int = 0) -> Any:
    """A linear system as a family along one state whose column is zero."""
    n = len(matrix)
    x = ca.SX.sym("x", n)
    names = tuple(f"x{i}" for i in range(n))
    system = st.System(
        "s", x, ca.SX(0, 1), ca.mtimes(ca.DM(matrix), x), states=names, parameters=()
    )
    held = {name: 0.0 for i, name in enumerate(names) if i != at}
    return st.Family(system, "steady", at=(names[at],), held=held)


def test_the_counterexample_grows_like_t() -> None:
    # x' = v, v' = 0, z' = -z: spectrally stable, and 0.4 said "open: higher orders decide"
    found = st.spectrum(steady([[0, 1, 0], [0, 0, 0], [0, 0, -1]]), at=0.3)
    assert found.verdict is st.Verdict.DRIFTING
    assert found.structural_zeros == 2
    assert found.growth() == "grows like t" and "drifting: grows like t" in repr(found)
    assert found.nonlinear is GROWS


def test_semisimple_zeros_are_not_said_to_grow() -> None:
    found = st.spectrum(steady([[0, 0, 1], [0, 0, 2], [0, 0, -1]]), at=0.3)
    assert found.structural_zeros == 2
    assert found.nonlinear is LINEAR


@pytest.mark.few(6)
@pytest.mark.parametrize("seed", range(40))
def test_random_systems_with_planted_blocks_against_exact_ranks(seed: int) -> None:
    """The rank by SymPy over Q and the growth of expm decide; integers, so nothing is rounded."""
    rng = np.random.default_rng(seed)
    zeros, rest = int(rng.integers(2, 4)), int(rng.integers(1, 4))
    n = zeros + rest
    core = np.zeros((n, n), dtype=int)
    for i in range(zeros - 1):
        core[i, i + 1] = rng.integers(0, 2) * 2 ** int(rng.integers(0, 12))
    core[zeros:, zeros:] = -np.diag(rng.integers(1, 9, rest)) + np.triu(
        rng.integers(-4, 5, (rest, rest)), 1
    )
    core[:zeros, zeros:] = rng.integers(-5, 6, (zeros, rest))
    basis = np.eye(n, dtype=int)
    for _ in range(4):  # unimodular, and the first column stays the first unit vector
        i, j = rng.integers(1, n, 2)
        if i != j:
            step = np.eye(n, dtype=int)
            step[i, j] = rng.integers(-2, 3)
            basis = basis @ step
    matrix = basis @ core @ np.round(np.linalg.inv(basis)).astype(int)
    exact = sp.Matrix(matrix.tolist())
    found = st.spectrum(steady(matrix.tolist()), at=0.5)
    if found.verdict not in (st.Verdict.STABLE, st.Verdict.DRIFTING):
        assert found.nonlinear is LINEAR
        return
    assert found.structural_zeros == zeros
    power = next(p for p in range(zeros) if (exact ** (p + 1)).rank() == n - zeros)
    semisimple = power == 0
    assert found.verdict is (st.Verdict.STABLE if semisimple else st.Verdict.DRIFTING)
    assert found.nonlinear is (LINEAR if semisimple else GROWS)
    proved = st.spectrum(steady(matrix.tolist()), at=0.5, certify=True)
    assert proved.verdict is found.verdict and proved.certified
    if power:
        assert found.power == proved.power == power
        assert found.growth() == "grows like t" + ("" if power == 1 else "²")
    late = np.linalg.norm(expm(1e4 * matrix.astype(float)))
    early = np.linalg.norm(expm(1e3 * matrix.astype(float)))
    assert (late > 5 * early) == (not semisimple)


def test_a_coupling_below_its_rounding_is_left_open() -> None:
    """1e-17 made of a difference of ones is not proved to be there."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    small = (1 + p) * x[1] - x[1] - p * x[1]  # zero, but not for the graph
    system = st.System(
        "s", x, p, ca.vertcat(small, 0, -x[2]), states=("x", "v", "z"), parameters=("p",)
    )
    rest = st.Family(system, "rest", at=("x",), held={"v": 0.0, "z": 0.0})
    assert st.spectrum(rest, at=0.3, p=0.1).nonlinear is LINEAR


def test_many_points_are_judged_one_by_one() -> None:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    system = st.System(
        "s", x, p, ca.vertcat(p * x[1], 0, -x[2]), states=("x", "v", "z"), parameters=("p",)
    )
    rest = st.Family(system, "rest", at=("x",), held={"v": 0.0, "z": 0.0})
    found = st.spectrum(rest, at=0.3, p=[0.0, 1.0, 1e-12])
    assert found.nonlinear.tolist() == [LINEAR, GROWS, GROWS]


def test_the_disks_zeros_are_semisimple_in_every_family_and_law() -> None:
    """Exact elimination over the rational functions; doubles prove no larger rank."""
    for law in ("smooth", "viscous", "linear-viscous", "rough"):
        for name in ("rolling", "spinning", "tumbling"):
            family = st.disk_family(name, law)
            assert semisimple(family, structure(family).zeros), (name, law)
    family = st.disk_family("rolling", "viscous")
    a, q = np.array([[1.8], [3.0]]), np.array([[0.25, 0.3], [0.5, 2.0]])
    assert not drift_powers(family, a, q, family.solve(a, q), 2, None).any()


# --- every way to ask ---


def hover() -> st.Family:
    """A craft whose tilt nobody holds: a push grows until drag balances what the tilt pulls."""
    tilt, rate, v, lift, m, c = (ca.SX.sym(n) for n in ("tilt", "rate", "v", "lift", "m", "c"))
    rates = ca.vertcat(rate, 0 * rate, (-lift * ca.sin(tilt) - c * v) / m)
    system = system_of("hover", [tilt, rate, v], [lift, m, c], rates)
    return st.Family(system, "level", at=("lift",), held={"tilt": 0, "rate": 0, "v": 0})


def test_a_hover_drifts_in_every_answer(tmp_path: Any, capsys: Any) -> None:
    level, plane = hover(), {"x": ("lift", 1, 50, 5), "y": ("c", -0.1, 1, 6), "m": 4.0}
    for certify in (False, True):
        one = st.spectrum(level, at=39.2, m=4.0, c=0.05, certify=certify)
        assert one.verdict is st.Verdict.DRIFTING and "grows like t" in one.reason
    assert one.to_xarray().verdict == st.Verdict.DRIFTING.code == 5
    for certify in (False, True):
        cells = st.stability_map(level, **plane, certify=certify)
        assert (cells.verdict == np.where(cells.c > 0, 5, 2)[:, None]).all()
    assert set(cells.box_verdict.values.tolist()) == {0, 5}
    assert "drifting" in cells.verdict.attrs["flag_meanings"].split()
    [edge] = st.boundaries(level, axis=("c", -1, 1, 9), at=3.0, m=4.0)
    assert (edge.value, edge.good, edge.stable_below) == (0.0, st.Verdict.DRIFTING, False)
    found = st.conditions(level)
    assert found.rule == "Drifting where m*c > 0; unstable where it is negative."
    assert found.verdict(39.2, m=4.0, c=0.05) is st.Verdict.DRIFTING
    with pytest.raises(st.StabilityError, match="Jordan block.*growth=True"):
        st.stream_map(level, **plane, out=tmp_path / "m.zarr")
    grown = xarray.open_zarr(st.stream_map(level, **plane, out=tmp_path / "m.zarr", growth=True))
    assert (grown.verdict == cells.verdict).all()
    file = tmp_path / "hover.py"
    file.write_text(HOVER)
    assert (
        main(
            [
                "boundaries",
                "--system",
                f"{file}:level",
                "--axis",
                "c:-1:1:9",
                "--set",
                "m=4",
                "--at",
                "3",
            ]
        )
        == 0
    )
    assert "static, drifting above" in capsys.readouterr().out


def test_a_pushed_hover_does_run_away() -> None:
    """The oracle of the word: tilt = 1e-3 t, so that v tends to -lift·tilt/c and grows with it."""
    run = st.simulate(hover().system, [39.2, 4.0, 0.05], [0.0, 1e-3, 0.0], [50.0, 100.0, 200.0])
    speed = np.abs(run.v.values)
    assert (speed[1:] > 1.8 * speed[:-1]).all() and speed[-1] > 50


def test_a_block_that_comes_and_goes_along_an_axis() -> None:
    """With x' = b y, only at b = 0 the two zeros are semisimple."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    rates = ca.vertcat(p[1] * x[1], 0 * x[1], x[0] - p[0] * x[2])
    system = st.System("s", x, p, rates, states=("x", "y", "z"), parameters=("a", "b"))
    rest = st.Family(system, "rest", at=("a",), held={"x": 0, "y": 0, "z": 0})
    cells = st.stability_map(rest, x=("a", -1, 1, 3), y=("b", -1, 1, 3))
    assert cells.verdict.values.tolist() == [[2, 3, 5], [2, 3, 1], [2, 3, 5]]
    found = st.spectrum(rest, at=1.0, b=[-1, 0, 1e-30], certify=True)
    assert [v.word for v in found.verdict] == ["drifting", "stable", "drifting"]
    assert st.conditions(rest).verdict(1.0, b=0) is st.Verdict.STABLE


@pytest.mark.parametrize("law", ["algebraic", "transcendental"])
def test_a_block_that_the_members_equation_undoes(law: str) -> None:
    """With u² = p, or exp u = p, (u² - p) y is zero at every member, and u y is not."""
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p")
    off = x[3] ** 2 - p if law == "algebraic" else ca.exp(x[3]) - p
    for coupling, word in ((off, "stable"), (x[3], "drifting")):
        rates = ca.vertcat(coupling * x[1], 0 * x[1], x[0] - x[2], -off)
        system = st.System("s", x, p, rates, states=("x", "y", "z", "u"), parameters=("p",))
        rest = st.Family(
            system,
            "rest",
            at=("p",),
            held={"x": 0, "y": 0, "z": 0},
            unknown={"u": 1.0},
            equations=("u",),
        )
        for certify in (False, True):
            found = st.spectrum(rest, at=[2.0, 3.0], certify=certify)
            assert [v.word for v in found.verdict] == [word, word]


def test_left_out_states_do_not_drift() -> None:
    """A place that no rate depends on is left out; what is left is at rest in its own speed."""
    x, c = ca.SX.sym("x", 3), ca.SX.sym("c")
    rates = ca.vertcat(x[1], 0 * x[1], -c * x[2])
    system = st.System("free", x, c, rates, states=("x", "v", "z"), parameters=("c",))
    free = st.Family(system, "free", at=("v",), held={"z": 0})
    assert st.spectrum(free, at=1.0, c=1.0).verdict is st.Verdict.STABLE


# --- planted blocks, every question twice and in random order ---


class Planted:
    """Zeros in Jordan blocks with couplings b, next to eigenvalues p - c."""

    def __init__(self, seed: int) -> None:
        self.draw = random.Random(f"blocks {seed}")
        system = self._drawn()
        while system.ignorable:  # what may be left out would not drift
            system = self._drawn()
        held = dict.fromkeys(system.states, 0)
        self.family = st.Family(system, "rest", at=("p",), held=held)

    def _drawn(self) -> st.System:
        draw = self.draw
        sizes = [draw.randint(1, 3) for _ in range(draw.randint(1, 3))]
        self.rates = [Fraction(draw.randint(-8, 8), 4) for _ in range(draw.randint(1, 3))]
        self.power, zeros = max(sizes) - 1, sum(sizes)
        n = zeros + len(self.rates)
        p, b, x = ca.SX.sym("p"), ca.SX.sym("b"), ca.SX.sym("x", n)
        core, place = ca.SX(n, n), 0
        for size in sizes:
            for i in range(place, place + size - 1):
                core[i, i + 1] = b * draw.choice([-3, -1, 1, 2])
            place += size
        for i, rate in enumerate(self.rates, start=place):
            core[i, i] = p - float(rate)
            for j in range(i):  # the other states feel the zeros, which no change of basis undoes
                core[i, j] = draw.choice([0, 1, -2])
        turn = back = ca.DM.eye(n)  # integers, so that the inverse is exact
        for _ in range(3):
            i, j = draw.sample(range(n), 2)
            step, undo = ca.DM.eye(n), ca.DM.eye(n)
            step[i, j] = draw.choice([-2, -1, 1, 2])
            undo[i, j] = -step[i, j]
            turn, back = ca.mtimes(turn, step), ca.mtimes(undo, back)
        rhs = ca.mtimes([turn, core, back, x])
        names = [f"x{i}" for i in range(n)]
        return st.System("s", x, ca.vertcat(p, b), rhs, states=names, parameters=("p", "b"))

    def word(self, p: Fraction, b: float) -> str:
        """The verdict, from what was planted."""
        top = p - min(self.rates)
        if top >= 0:
            return "unstable" if top > 0 else "neutral"
        return "drifting" if b and self.power else "stable"

    def ask(self, question: str) -> None:
        p, b = Fraction(self.draw.randint(-12, 12), 4), self.draw.choice([0.0, 1.0, -0.5])
        family, edge = self.family, min(self.rates)
        if question in ("spectrum", "proof"):
            found = st.spectrum(family, at=float(p), b=b, certify=question == "proof")
            assert found.verdict.word == self.word(p, b)
            if found.verdict is st.Verdict.DRIFTING:
                assert found.power == self.power
        elif question == "conditions":
            assert st.conditions(family).verdict(float(p), b=b).word == self.word(p, b)
        elif question == "boundaries":
            low, high = float(edge) - 1.5, float(edge) + 0.7
            found = st.boundaries(family, axis=("p", low, high, 9), b=b)
            [one] = found
            assert found.complete and one.value == float(edge) and one.stable_below
            assert one.good.word == self.word(edge - 1, b)
        else:
            found = st.stability_map(
                family, x=("p", -3, 3, 5), y=("b", -1, 1, 3), certify=self.draw.random() < 0.3
            )
            for i, b in enumerate(found.b.values):
                words = [st.Verdict(int(c)).word for c in found.verdict.values[i]]
                assert words == [self.word(Fraction(float(p)), b) for p in found.p.values]


@pytest.mark.parametrize(
    "seeds", [range(3), pytest.param(range(3, 500), marks=pytest.mark.long)], ids=["few", "many"]
)
def test_planted_blocks_are_told_twice_and_in_any_order(seeds: range) -> None:
    for seed in seeds:
        planted = Planted(seed)
        questions = 2 * ["spectrum", "proof", "conditions", "boundaries", "map"]
        planted.draw.shuffle(questions)
        for question in questions:
            try:
                planted.ask(question)
            except AssertionError as error:
                raise AssertionError(f"seed {seed}, {question}: {error}") from error
