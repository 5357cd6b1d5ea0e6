"""What a program keeps for its next run belongs to one number type, not to a name."""

from __future__ import annotations

import gc
import operator
import threading
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import brentq

import stability as st
from stability.algebra.number_types import Algebra, casadi_algebra
from stability.algebra.program import Program
from stability.systems.graph.constants import Constants


def scaled(factor: int) -> Algebra:
    """Whole numbers in units of 1/factor; every one of these number types has the same name."""
    return Algebra("scaled", lambda v: round(v * factor), {"sqrt": operator.neg})


def test_number_types_of_one_name_keep_their_own_constants() -> None:
    x, c = ca.SX.sym("x"), ca.SX.sym("c")
    program = Program(ca.Function("f", [x, c], [x + ca.sqrt(c)]), [2.0])
    one, ten = scaled(1), scaled(10)
    for _ in range(2):
        assert program.run(one, [[5]]) == [[3]]
        assert program.run(ten, [[5]]) == [[-15]]
    # a number type that is gone leaves its place, and nothing of itself, to the next
    for factor in range(20, 60):
        assert program.run(scaled(factor), [[5]]) == [[5 - 2 * factor]]
        gc.collect()
    assert len(program._held) <= 3


def test_threads_with_number_types_of_one_name_do_not_mix() -> None:
    x, c = ca.SX.sym("x"), ca.SX.sym("c", 40)
    program = Program(ca.Function("f", [x, c], [x + ca.sum1(ca.sqrt(c))]), [1.0] * 40)
    wrong: list[Any] = []

    def work(factor: int) -> None:
        for _ in range(100):
            if program.run(scaled(factor), [[0]]) != [[-40 * factor]]:
                wrong.append(factor)

    workers = [threading.Thread(target=work, args=(n,)) for n in (1, 2, 3)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert not wrong


def test_symbols_for_constants_stay_those_of_one_graph() -> None:
    x = ca.SX.sym("x")
    program = Program(ca.Function("f", [x], [x + 0.1]))
    first, second = Constants(), Constants()
    for constants in (first, second):
        [[value]] = program.run(constants.algebra(), [[x]])
        assert not set(map(str, ca.symvar(value))) - {"x", "c0"}
        assert ca.depends_on(value, constants.column)
    [[plain]] = program.run(casadi_algebra(), [[x]])
    assert [s.name() for s in ca.symvar(plain)] == ["x"]


def rooted() -> st.Family:
    """A zero by structure next to λ = (p - 1)√2, where √2 is a root of the graph at the member."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    rhs = ca.vertcat((p - 1) * ca.sqrt(2 + x[0]) * x[0], x[0] ** 2)
    system = st.System("rooted", x, p, rhs, states=("a", "c"), parameters=("p",))
    return st.Family(system, "origin", at=("c",), held={"a": 0.0})


def refused(ask: Any) -> str:
    """The reason of a refusal, which stands in brackets."""
    with pytest.raises(st.StabilityError) as refusal:
        ask()
    return str(refusal.value).split("(")[1].split(")")[0]


QUESTIONS = ("boundaries", "spectrum", "certify", "conditions", "latex")


@pytest.mark.parametrize("order", [QUESTIONS, QUESTIONS[::-1], QUESTIONS[2:] + QUESTIONS[:2]])
def test_questions_about_an_irrational_root_in_any_order_twice(order: tuple[str, ...]) -> None:
    family = rooted()
    ask = {
        "boundaries": lambda: [
            (float(b.value), b.crossing is st.Crossing.STATIC, b.stable_below)
            for b in st.boundaries(family, axis=("p", 0.2, 3, 9), at=0.5)
        ],
        "spectrum": lambda: st.spectrum(family, at=0.5, p=1.5).verdict.word,
        "certify": lambda: [
            st.spectrum(family, at=0.5, p=p, certify=True).verdict.word for p in (0.5, 1.5)
        ],
        "conditions": lambda: refused(lambda: st.conditions(family)),
        "latex": lambda: refused(lambda: st.latex(family)),
    }
    right: dict[str, Any] = {
        "boundaries": [(1.0, True, True)],
        "spectrum": "unstable",
        "certify": ["stable", "unstable"],
        "conditions": "an irrational root",
        "latex": "an irrational root",
    }
    for name in order * 2:
        assert ask[name]() == right[name], name


def test_a_body_with_a_root_in_its_height_is_asked_twice() -> None:
    body = st.Body(
        lambda t: ca.sqrt(2 * ca.sin(t) ** 2 + ca.cos(t) ** 2), axial=0.6, transverse=0.5
    )
    more: dict[str, Any] = {"body": body, "contact": st.Viscous(0.3)}

    def growth(rate: float) -> float:
        """The largest real part, by LAPACK."""
        return float(np.max(st.spectrum("spinning", at=rate, **more).eigenvalues.real))

    right = brentq(growth, 1.5, 2.5, xtol=1e-13)
    for _ in range(2):
        [found] = st.boundaries("spinning", axis=("at", 0.05, 20, 12), **more)
        assert found.value == pytest.approx(right, abs=1e-9)
        assert found.stable_below == (growth(1.5) < 0 < growth(2.5))
