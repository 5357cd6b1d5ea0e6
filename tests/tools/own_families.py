"""Families as a user would bring them to the explorer, and how its numbers are read."""

import math
from typing import Any

import casadi as ca
import numpy as np
from own_systems import system_of
from towed_wheel import GIVEN, towed_wheel

import stability as st

SHOWN = """() => {
  const {motion, view} = stabilityExplorer, {shown} = motion, {run} = motion.traces;
  const names = view.subject.states, {eigenvalue, until} = shown, q = view.point();
  return {eigenvalue, until, times: run.times, states: names.map((n) => run.series[n]),
    names: Object.keys(run.series), kind: motion.kindShown, steady: view.subject.steady(q)};
}"""
"""What the picture of the motion shows, and its curves."""


def governor() -> st.Family:
    """Watt's governor: its members are solved for, and it has no energy."""
    x, y, z, a, b, e = (ca.SX.sym(n) for n in ("x", "y", "z", "a", "b", "e"))
    rhs = ca.vertcat(y, z**2 * ca.sin(x) * ca.cos(x) - ca.sin(x) - e * y, a * (ca.cos(x) - b))
    system = system_of("governor", [x, y, z], [a, b, e], rhs)
    near = {"x": 1.0, "z": 1.4, "a": 0.5, "b": 0.5, "e": 0.4}
    return system.steady("e", held={"y": 0.0}, guess=near, equations=("y", "z"), name="running")


def spring() -> st.Family:
    """A weight on a stiff spring, and a current that dies out: with units and an energy."""
    z, v, i, k, c, g = (ca.SX.sym(n) for n in ("height", "rise", "current", "k", "c", "g"))
    system = system_of(
        "spring",
        [z, v, i],
        [k, c, g],
        [v, -k * z - c * v - g, -i],
        observables={"tension": k * z, "power": c * v**2, "energy": (v**2 + k * z**2) / 2 + g * z},
        units={
            "height": "m",
            "rise": "m/s",
            "current": "A",
            "k": "1/s2",
            "c": "1/s",
            "g": "m/s2",
            "energy": "J/kg",
            "power": "W/kg",
        },
    )
    return st.Family(
        system,
        "hanging",
        at=("g",),
        held={"rise": 0.0, "current": 0.0},
        unknown={"height": -0.001},
        equations=("rise",),
    )


def rotor() -> st.Family:
    """Jeffcott's rotor: both directions have one size, so that the first has phase 0."""
    x, y, u, v = (ca.SX.sym(n) for n in ("x", "y", "u", "v"))
    turn, w, de, di = (ca.SX.sym(n) for n in ("W", "w", "de", "di"))
    rates = ca.vertcat(
        u, v, -(de + di) * u - w**2 * x - turn * di * y, -(de + di) * v - w**2 * y + turn * di * x
    )
    system = system_of(
        "rotor",
        [x, y, u, v],
        [turn, w, de, di],
        rates,
        units={"x": "m", "y": "m", "u": "m/s", "v": "m/s"},
    )
    return st.Family(system, "centred", at=("W",), held=dict.fromkeys(system.states, 0.0))


CASES: dict[str, tuple[Any, dict[str, Any]]] = {
    "wheel": (towed_wheel, {"at": 0.3, **GIVEN}),
    "governor": (governor, {"at": 0.3, "a": 0.5, "b": 0.5}),
    "spring": (spring, {"at": 9.81, "k": 1e4, "c": -3.0}),
    "rotor": (rotor, {"at": 3.0, "w": 1.0, "de": 0.03, "di": 0.02}),
}
"""Families with a real mode, growing oscillations, states of very different and of equal sizes."""


def number(text: str) -> float:
    """A number as the page writes it."""
    plain = (
        text.replace("−", "-")
        .replace("·10", "e")
        .translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
    )
    return float(plain)


def vector_of(known: st.Spectrum, eigenvalue: complex) -> np.ndarray:
    """Python's eigenvector of an eigenvalue, over its largest component."""
    gaps = np.abs(known.eigenvalues - eigenvalue)
    assert gaps.min() < 1e-9 * np.abs(known.eigenvalues).max()
    vector = np.asarray(known.modes.vectors[int(gaps.argmin())])
    sizes = np.abs(vector)
    found: np.ndarray = vector / vector[np.flatnonzero(sizes >= (1 - 1e-6) * sizes.max())[0]]
    return found


def agrees(size: str, phase: str, true: complex) -> None:
    """A size and a phase equal Python's to the printed digits."""
    if size == "0":
        assert abs(true) < 1e-9 and phase == "–"
        return
    last = 10.0 ** (math.floor(math.log10(abs(true))) - (2 if abs(true) >= 1e-3 else 1))
    assert abs(number(size) - abs(true)) <= 0.5001 * last
    apart = (number(phase.removesuffix("°")) - math.degrees(np.angle(true)) + 180) % 360 - 180
    assert abs(apart) <= 0.0501
