"""Modes of a user's own family as the page computes them: curves, sizes, phases, steady values."""

import math
import re
from typing import Any

import casadi as ca
import numpy as np
import pytest
from node import Engine
from own_families import CASES, SHOWN, agrees, vector_of

import stability as st

SAME = 1e-6
"""Largest difference of a curve from Python's, over the amplitude."""
SHOW = "(more) => { stabilityExplorer.view.set(more); stabilityExplorer.motion.run(); }"
WORDS = """() => {
  const {motion, view, words} = stabilityExplorer, {parts} = motion.shown;
  const cells = ({size, phase}) => [words.sizeText(size), size ? words.phaseText(phase) : "–"];
  return {said: words.componentsText(parts, view.subject.states, 0), cells: parts.map(cells)};
}"""
"""Sizes and phases as the sentence says them, and as the table of states does."""
Own = tuple[Engine, st.Family, st.Spectrum]
SLOWER = [pytest.param(name, marks=pytest.mark.long) for name in ("wheel", "governor")]


@pytest.fixture(scope="module", params=["spring", "rotor", *SLOWER])
def own(request: Any, tmp_path_factory: pytest.TempPathFactory) -> Own:
    make, given = CASES[request.param]
    family, path = make(), tmp_path_factory.mktemp("own") / "own.html"
    page = Engine(st.explore(family, certify=False, out=path, **given))
    return page, family, st.spectrum(family, **given)


def modes_of(page: Engine) -> int:
    """How many modes the page lists."""
    listed = "({modes, view}) => modes.modesAt(view.subject, view.point()).length"
    return int(page.evaluate(f"({listed})(stabilityExplorer)"))


def chosen(page: Engine, index: int) -> dict[str, Any]:
    """Choose a mode; what is shown then."""
    page.evaluate(SHOW, {"show": "mode", "mode": index, "tilt": 0.25})
    found: dict[str, Any] = page.evaluate(SHOWN)
    assert found["kind"] == "mode"
    return found


def test_curves_of_a_mode_are_those_of_pythons_eigenvectors(own: Own) -> None:
    page, family, known = own
    assert modes_of(page) == np.count_nonzero(known.eigenvalues.imag >= 0)
    steady = np.asarray(known.states).reshape(-1)
    for index in range(modes_of(page)):
        found = chosen(page, index)
        value = complex(*found["eigenvalue"])
        vector = vector_of(known, value)
        times, states = np.array(found["times"]), np.array(found["states"])
        assert len(states) == len(family.system.states) and times[0] == 0
        for at in (0, 137, len(times) - 1):
            true = steady + 0.25 * (vector * np.exp(value * times[at])).real
            reach = 0.25 * max(1.0, abs(np.exp(value * times[at])))
            assert states[:, at] == pytest.approx(true, abs=SAME * reach)
        # a few periods, or e-folding times
        period = 2 * math.pi / abs(value.imag) if value.imag else math.inf
        assert found["until"] == pytest.approx(min(3 * period, 6 / abs(value.real)), rel=1e-9)
        factor = page.evaluate("stabilityExplorer.motion.shown.factor")
        assert factor == pytest.approx(math.exp(value.real * found["until"]), rel=1e-9)


def test_sizes_and_phases_are_pythons(own: Own) -> None:
    page, family, known = own
    for index in range(modes_of(page)):
        vector = vector_of(known, complex(*chosen(page, index)["eigenvalue"]))
        words = page.evaluate(WORDS)
        for (size, phase), true in zip(words["cells"], vector, strict=True):
            agrees(size, phase, true)
        parts = re.findall(r"(\w+) ([^ ]+) \(([^)]+)\)", words["said"])
        assert parts[0][1:] == ("1", "0°")
        assert {n for n, *_ in parts} == {
            n for n, v in zip(family.system.states, vector, strict=True) if abs(v) > 1e-9
        }
        for name, size, phase in parts:
            agrees(size, phase, vector[family.system.states.index(name)])


def test_every_state_has_its_steady_value_and_unit(own: Own) -> None:
    page, family, known = own
    steady = np.asarray(known.states).reshape(-1)
    page.evaluate(SHOW, {"show": "steady"})
    found = page.evaluate(SHOWN)
    assert found["kind"] == "steady" and found["steady"] == pytest.approx(steady, abs=1e-11)
    assert np.array(found["states"])[:, [0, -1]].T == pytest.approx(
        np.array([steady, steady]), abs=1e-11
    )
    for name in family.system.states:
        unit = page.evaluate("(name) => stabilityExplorer.view.curve(name).unit", name)
        assert unit == family.system.units.get(name, "")


def test_only_an_observable_named_energy_has_a_curve_of_the_energy(own: Own) -> None:
    page, family, _ = own
    page.evaluate(SHOW, {"show": "launch", "tilt": 0.1})
    names = page.evaluate(SHOWN)["names"]
    assert names[: len(family.system.states)] == list(family.system.states)
    has = "energy" in family.system.observables
    assert ("energy" in names) == has
    if not has:
        return
    run = page.evaluate("({...stabilityExplorer.motion.traces.run.series})")
    x, p = family.system.x, family.system.p
    energy = ca.Function("energy", [x, p], [family.system.observables["energy"]])
    values = page.evaluate("stabilityExplorer.view.state.values")
    given = [values[n] for n in family.system.parameters]
    for at in (0, 400):
        state = [run[n][at] for n in family.system.states]
        assert run["energy"][at] == pytest.approx(float(energy(state, given)), rel=1e-9, abs=1e-12)
