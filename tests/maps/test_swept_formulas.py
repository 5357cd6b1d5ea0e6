"""Compiled loops over formulas: cells as by NumPy, and bounds that hold the certified rates."""

from __future__ import annotations

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.base.verdict import CODES, NO_MEMBER
from stability.maps import engine as module

pytest.importorskip("numba")

BODIES = {
    "torus": (st.Torus(0.2), ("tube", 0.02, 0.9)),
    "spheroid": (st.Spheroid(0.6), ("aspect", 0.2, 1.6)),  # a square root
    "sphere": (st.EccentricSphere(0.2), ("offset", 0.01, 0.9)),
    "disk with a rim": (st.ThickDisk(0.1), ("thickness", 0.01, 1.2)),
    "egg": (st.Egg(0.2), ("axial", 0.2, 0.6)),
    "SI": (st.Torus(0.15, mass=2.0, gravity=9.81, length=0.3), ("tube", 0.02, 0.9)),
}
MADE = {
    "spheroid": st.Spheroid,
    "disk with a rim": st.ThickDisk,
    "egg": lambda axial: replace(BODIES["egg"][0], axial=axial),
}
ALWAYS = {"torus", "spheroid", "SI"}
"""Bodies that tumble at every inclination and number here."""
WIDE, TALL = 301, 23  # more columns than one block of lanes has


def cells(
    name: str, law: str, monkeypatch: pytest.MonkeyPatch, least: int, *, turned: bool = False
) -> Any:
    """A map of tumbling with all its cells from formulas, by loops from so many cells on."""
    monkeypatch.setattr(module, "COMPILED_FROM", least)
    body, number = BODIES[name]
    axes = {"x": ("at", 0.05, 3.1, WIDE), "y": (*number, TALL)}
    if turned:
        axes = {"x": (*number, WIDE), "y": ("at", 0.05, 3.1, TALL)}
    return st.stability_map("tumbling", contact=law, body=body, boundaries=False, **axes)


@pytest.mark.few(3)
@pytest.mark.parametrize("turned", [False, True], ids=["", "turned"])
@pytest.mark.parametrize("law", ["rough", "smooth"])
@pytest.mark.parametrize("name", BODIES)
def test_loops_give_the_cells_of_numpy(
    name: str, law: str, turned: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    loops, plain = (cells(name, law, monkeypatch, n, turned=turned) for n in (0, 10**9))
    assert "compiled loops" in loops.attrs["method"]
    assert "compiled loops" not in plain.attrs["method"]
    assert (loops.verdict.values == plain.verdict.values).all()
    there = loops.verdict.values != NO_MEMBER
    assert 0.05 < there.mean()
    assert there.all() == (name in ALWAYS)
    for rate in ("abscissa", "frequency"):
        one, other = loops[rate].values, plain[rate].values
        assert (np.isnan(one) == ~there).all()
        size = 1 + np.abs(other[there])
        bound = loops.abscissa_error.values + plain.abscissa_error.values
        assert (np.abs(one - other)[there] <= bound[there] + 1e-12 * size).all()
    assert (np.abs(loops.abscissa - plain.abscissa).values[there] <= bound[there]).all()


@pytest.mark.few(1)
@pytest.mark.parametrize("name", MADE)
def test_certified_rates_lie_within_the_bounds(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found = cells(name, "smooth", monkeypatch, 0)
    _, (number, *_) = BODIES[name]
    random = np.random.default_rng(11)
    there = np.argwhere(found.verdict.values != NO_MEMBER)
    for i, j in there[random.choice(len(there), 8, replace=False)]:
        cell = found.isel({number: i, "theta": j})
        one = MADE[name](float(cell[number]))
        true = st.spectrum(
            "tumbling", at=float(cell.theta), contact="smooth", body=one, certify=True
        )
        off = float(cell.abscissa_error) + true.abscissa_error
        assert abs(float(cell.abscissa) - true.abscissa) <= off + 1e-15 * true.abscissa
        assert int(cell.verdict) == CODES[true.verdict]


def test_the_loops_travel_to_other_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    kept: list[module.FormulaCells] = []
    made = module.FormulaCells.__init__

    def noted(self: module.FormulaCells, *given: Any) -> None:
        made(self, *given)
        kept.append(self)

    monkeypatch.setattr(module.FormulaCells, "__init__", noted)
    cells("torus", "rough", monkeypatch, 0)
    x, y = np.linspace(0.2, 1.5, 30), np.linspace(0.1, 0.5, 20)
    one, other = (c.band(x, y) for c in (kept[-1], pickle.loads(pickle.dumps(kept[-1]))))
    assert (one["codes"] == other["codes"]).all()
    assert np.array_equal(one["abscissa"], other["abscissa"])
