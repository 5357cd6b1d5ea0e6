"""One table of the disk's quantities: nothing else states a unit, a symbol or a name in words."""

from __future__ import annotations

import ast
import math
import pickle
import re
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import matplotlib.pyplot as plt
import numpy as np
import pytest

import stability as st
from stability.base.quantities import Kind, axis_label, in_latex
from stability.bodies.contact_laws import MOTION_LAWS, law_class
from stability.bodies.quantities import QUANTITIES, disk_quantities, quantities_of
from stability.bodies.thin_disk import disk_system
from stability.figures.motion import caption

PACKAGE = Path(st.__file__).parent
TABLES = ("base/quantities.py", "bodies/quantities.py")
OPTIONS = {("cli/simulate.py", "theta")}
"""File and first key of dictionaries that say what an option of the command line takes."""
UNITS = {unit for kind in Kind for unit in (kind.si, kind.words)} - {"", "1"}
LINK = {"kg": 2.0, "m": 3.0, "s": 7.0, "rad": 1.0, "N": 6 / 49, "J": 18 / 49, "W": 18 / 343}
"""Arbitrary sizes of the SI units; what is equal in these is equal in dimension."""


def _texts(node: ast.AST | None) -> list[str]:
    """The strings of a constant or of a tuple of constants; none of a format or of something else.

    A name of a quantity is no text: such a table says which quantity, and nothing about it.
    """
    parts = node.elts if isinstance(node, ast.Tuple) else [node]
    found = [p.value for p in parts if isinstance(p, ast.Constant) and isinstance(p.value, str)]
    return [t for t in found if "{" not in t and (len(t) == 1 or t not in QUANTITIES)]


def tables_of_facts(folder: Path) -> Iterator[tuple[str, str]]:
    """File and first key of every dictionary that maps quantities to words, or holds units."""
    for path in sorted(folder.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.Dict):
                continue
            keys = [k.value if isinstance(k, ast.Constant) else None for k in node.keys]
            told = sum(
                k in QUANTITIES and bool(_texts(v)) for k, v in zip(keys, node.values, strict=True)
            )
            units = UNITS & {*filter(None, keys), *(t for v in node.values for t in _texts(v))}
            if told > 1 or len(units) > 1:
                yield path.relative_to(folder).as_posix(), str(keys[0])


@pytest.mark.long
def test_no_unit_symbol_or_name_is_stated_in_a_second_place() -> None:
    found = set(tables_of_facts(PACKAGE))
    own = "tables/benchmarks/"  # systems of their own, with their own units
    assert {t for t in found if t[0] not in TABLES and not t[0].startswith(own)} == OPTIONS


def test_a_second_table_would_be_found(tmp_path: Path) -> None:
    for text in (
        '{"theta": "rad", "omega3": "1/s"}',
        '{"slip_x": ("slip", "speed"), "phi": ("p", "angle")}',
        r'{"mu": "\\mu", "k": "k"}',
        '{"angle": "rad", "rate": "rad/s"}',
        '{"√(g/R)": 1, "m g": 2}',
    ):
        (tmp_path / "module.py").write_text(f"TABLE = {text}\n", encoding="utf-8")
        assert list(tables_of_facts(tmp_path)), text


@pytest.mark.parametrize("law", MOTION_LAWS)
def test_every_number_of_the_disk_has_a_quantity(law: str) -> None:
    system = disk_system(law)
    known = quantities_of(system.name)
    assert known == disk_quantities(law_class(law))
    for name in (*system.states, *system.parameters, *system.observables):
        assert known[name].long_name
        assert system.units[name] == known[name].kind.unit(dimensionless=True)
    if "mu" in system.parameters:
        assert known["mu"].kind.si == ("1" if law.startswith("coulomb") else "s/m")
    assert [n for n, q in known.items() if n != q.name] == []


def _size(words: str, sizes: dict[str, float]) -> float:
    """The size of a unit such as `m √(g/R)`."""
    code = re.sub(r"(?<=[A-Za-z)])(?=√)|(?<=g)(?=R)| ", "*", words).replace("**", "*")
    code = re.sub(r"(?<=[a-z])2", "**2", code).replace("√", "sqrt")
    return float(eval(code, {"sqrt": math.sqrt}, sizes))


def test_both_units_of_a_kind_have_one_dimension() -> None:
    scales = {"m": LINK["kg"], "R": LINK["m"], "g": LINK["m"] / LINK["s"] ** 2}
    kinds = [kind for kind in Kind if kind.words]
    assert len(kinds) > 10
    for kind in kinds:
        assert _size(kind.words, scales) == pytest.approx(_size(kind.si, LINK), rel=1e-12), kind


def test_a_series_is_its_dimensionless_numbers_times_the_unit_in_words() -> None:
    body = {"mass": 0.3, "radius": 0.2, "gravity": 9.81}
    sizes = {"m": body["mass"], "R": body["radius"], "g": body["gravity"]}
    rate, speed = math.sqrt(9.81 / 0.2), math.sqrt(9.81 * 0.2)
    times = np.linspace(0, 2, 5)
    plain = st.simulate(
        st.Disk(), st.Viscous(0.3), {"theta": 1.3, "omega3": 1.2, "slip_x": 0.1}, times, pose=True
    )
    si = st.simulate(
        st.Disk(**body),
        st.Viscous(0.3 / speed),
        {"theta": 1.3, "omega3": 1.2 * rate, "slip_x": 0.1 * speed},
        times / rate,
        pose=True,
    )
    series = [str(n) for n, v in plain.variables.items() if v.dims == ("time",)]
    assert {"power", "contact_x", "theta_dot", "energy", "time"} <= set(series)
    for name in series:
        unit = plain[name].attrs.get("unit_in_words")
        assert unit == (QUANTITIES[name].kind.words or None)
        scale = _size(unit, sizes) if unit else 1.0
        assert np.allclose(si[name], plain[name] * scale, rtol=1e-6, atol=1e-9 * scale), name


def test_a_unit_in_latex_is_that_of_its_kind() -> None:
    shown = {in_latex(unit) for kind in Kind for unit in (kind.si, kind.words)}
    assert {r"$\sqrt{g/R}$", r"$m\sqrt{g/R}$", r"$1/\sqrt{gR}$", "$mgR$", "m/s$^2$", "m"} <= shown
    assert in_latex("") == ""
    assert in_latex("m2/s") == "m²/s" and in_latex("beat2") == "beat2"  # a user's own units


def _labels(figure: object) -> set[str]:
    axes = figure.axes  # type: ignore[attr-defined]
    boxes = [a.get_legend() for a in axes if a.get_legend()]
    legends = [t.get_text() for legend in boxes for t in legend.get_texts()]
    return {text for a in axes for text in (a.get_xlabel(), a.get_ylabel())} | set(legends)


def test_axes_of_the_disk_have_its_names_symbols_and_units() -> None:
    disk = st.Disk(mass=0.3, radius=0.2, gravity=9.81)
    found = st.stability_map(
        "rolling",
        x=("at", 3, 4, 3),
        y=("mass", 0.2, 0.6, 3),
        disk=disk,
        contact=st.LinearViscous(0.3),
        boundaries=False,
    )
    assert {r"axial angular velocity $\omega_3$  [rad/s]", "mass $m$  [kg]"} < _labels(
        st.plot_map(found)
    )
    spectra = st.spectrum("tumbling", at=np.linspace(0.5, 1, 5), contact=st.Smooth())
    assert r"axis inclination $\theta$  [rad]" in _labels(st.plot_locus(spectra))


def test_a_users_theta_is_not_the_disks() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    system = st.System(
        "free",
        x,
        p,
        ca.vertcat(0 * x[0], -p * x[1]),
        states=("theta", "omega3"),
        parameters=("mu",),
        units={"theta": "m", "mu": "1/s"},
    )
    family = st.Family(
        system,
        "still",
        ("theta",),
        held={"omega3": 0.0},
        unknown={},
        equations=(),
        typical={"theta": 1.0, "mu": 0.3},
    )
    spectra = st.spectrum(family, at=np.linspace(0.5, 1, 5), mu=0.3)
    assert {"theta  [m]", "1: omega3"} < _labels(st.plot_locus(spectra))
    found = st.stability_map(family, x=("theta", 0.5, 1, 3), y=("mu", 0.1, 1, 3))
    assert {"theta  [m]", "mu  [1/s]"} < _labels(st.plot_map(found))


@pytest.mark.few(3)
@pytest.mark.parametrize(
    ("law", "given"),
    [
        (st.Viscous(0.3), "μ = 0.3 s/m"),
        (st.LinearViscous(mu=0.3), "μ = 0.3 s/m"),
        (st.LinearViscous(0.3), "c = 0.3 kg/s"),
        (st.Coulomb(0.3), "μ = 0.3 (|F| = μ N))"),
    ],
)
def test_a_caption_gives_the_coefficient_in_the_unit_of_its_law(
    law: st.Contact, given: str
) -> None:
    disk = st.Disk(mass=0.3, radius=0.2, gravity=9.81)
    told = caption(st.simulate(disk, law, {"theta": 1.2, "omega3": 3.0}, 0.1, check=False))
    assert given in told and "g = 9.81 m/s²" in told


@pytest.mark.parametrize(
    ("law", "formula"),
    [
        ("viscous", r"$F = -\mu\,N\,v$"),
        ("coulomb", r"$|F| = \mu\,N$"),
        ("coulomb-regularised", r"$F = -\mu\,N\,v/\sqrt{v^2+\varepsilon^2}$"),
        ("creep-2", r"$F = -\mu\,N\,v$"),
    ],
)
def test_an_axis_of_mu_says_the_law(law: str, formula: str) -> None:
    known = disk_quantities(MOTION_LAWS[law])["mu"]
    unit = known.kind.label(dimensionless=False)
    label = axis_label(known, "mu", unit)
    assert f"friction coefficient $\\mu$ of {formula}" in label
    assert known.value(0.3, dimensionless=False).endswith(f" ({MOTION_LAWS[law].formula})")
    plt.figure().text(0, 0, label).get_window_extent()  # Matplotlib reads the formula
    plt.close("all")


def test_every_law_of_the_package_says_its_formula() -> None:
    assert all(law.formula for law in MOTION_LAWS.values())


SCALES_IN_PART = {
    "the coin of an hour": lambda: st.Disk(mass=0.0058, radius=0.012125),
    "gravity alone": lambda: st.Disk(gravity=9.81),
    "a hoop": lambda: st.Disk.hoop(mass=0.3, radius=0.45),
    "an annulus": lambda: st.Disk.annulus(0.1, radius=0.2),
    "a torus": lambda: st.Torus(0.2, mass=1, length=0.3),
    "an egg": lambda: st.Egg(0.1, gravity=9.81),
    "a body": lambda: st.Body(ca.sin, axial=0.4, transverse=0.25, mass=2),
    "a copy": lambda: replace(st.Disk(k=0.3), radius=0.1),
    "other numbers": lambda: st.Disk().having({"mass": 0.1}),
    "other numbers of a body": lambda: st.Torus(0.2).having({"gravity": 9.81}),
    "an axis": lambda: st.stability_map(
        "rolling", x=("at", 1, 2, 3), y=("radius", 0.1, 0.2, 3), contact=st.Viscous(0.3)
    ),
    "an axis of boundaries": lambda: st.boundaries(
        "rolling", axis=("gravity", 1, 10, 3), at=1, contact=st.Viscous(0.3)
    ),
    "an axis of a disk as body": lambda: st.boundaries(
        "rolling", axis=("gravity", 1, 10, 3), at=1, contact=st.Viscous(0.3), body=st.Disk()
    ),
    "an axis of a body": lambda: st.boundaries(
        "rolling", axis=("length", 1, 10, 3), at=1, contact=st.Viscous(0.3), body=st.Torus(0.2)
    ),
}


@pytest.mark.parametrize("call", SCALES_IN_PART.values(), ids=SCALES_IN_PART)
def test_mass_length_and_gravity_are_given_all_or_none(call: Callable[[], Any]) -> None:
    sentence = (
        r"the \w+ has (mass|radius|length|gravity) and no (mass|radius|length|gravity); "
        r"give mass, (radius|length) and gravity in SI units, or none of them\.$"
    )
    with pytest.raises(st.StabilityError, match=sentence):
        call()


def test_all_three_numbers_or_none_are_accepted_also_where_they_are_one() -> None:
    assert st.Disk(mass=1, radius=1, gravity=1).dimensionless
    assert replace(st.Disk.named("quarter"), radius=0.01).gravity == 9.81
    assert pickle.loads(pickle.dumps(st.Torus(0.2))).having({"tube": 0.3}).length == 1
    with pytest.raises(st.StabilityError, match="has radius and no mass"):
        replace(pickle.loads(pickle.dumps(st.Disk())), radius=0.1)


def test_a_lone_number_for_a_disk_is_refused_because_it_is_the_mass() -> None:
    with pytest.raises(st.StabilityError, match=r"Disk\(0.5\) gives the mass alone; .*Disk\(k="):
        st.Disk(0.5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert st.Disk(0.3, 0.45, 0.5, 9.81).k == st.Disk(k=0.5).k == 0.5
        assert pickle.loads(pickle.dumps(st.Disk(k=0.5))) == st.Disk(k=0.5)
