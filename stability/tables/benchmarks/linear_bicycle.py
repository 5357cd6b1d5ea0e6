"""The linear bicycle from its 25 parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from ...spectra.spectrum import spectrum
from ...systems.family import Family
from ...systems.system import System
from .row import PUBLISHED, BenchmarkRow, Source, at_threshold, compared, threshold

LINEAR = Source("linear bicycle", "Meijaard et al., Proc. R. Soc. A 463 (2007) 1955, Table 1")
BENCHMARK: dict[str, Any] = {
    "w": 1.02,
    "c": 0.08,
    "lam": math.pi / 10,
    "g": 9.81,
    "rR": 0.3,
    "mR": 2.0,
    "IRxx": 0.0603,
    "IRyy": 0.12,
    "xB": 0.3,
    "zB": -0.9,
    "mB": 85.0,
    "IBxx": 9.2,
    "IByy": 11.0,
    "IBzz": 2.8,
    "IBxz": 2.4,
    "xH": 0.9,
    "zH": -0.7,
    "mH": 4.0,
    "IHxx": 0.05892,
    "IHyy": 0.06,
    "IHzz": 0.00708,
    "IHxz": -0.00756,
    "rF": 0.35,
    "mF": 3.0,
    "IFxx": 0.1405,
    "IFyy": 0.28,
}
"""Parameters of the benchmark in SI units: w wheelbase, c trail, lam tilt of the steering axis."""
ENTRIES = {
    "M_00": "80.81722",
    "M_01": "2.31941332208709",
    "M_11": "0.29784188199686",
    "C1_01": "33.86641391492494",
    "C1_10": "-0.85035641456978",
    "C1_11": "1.68540397397560",
    "K0_00": "-80.95",
    "K0_01": "-2.59951685249872",
    "K0_11": "-0.80329488458618",
    "K2_01": "76.59734589573222",
    "K2_11": "2.65431523794604",
}
"""Entries of the matrices as printed; the others are zero, or follow by symmetry."""
EIGENVALUES = {
    "castering eigenvalue at 5 m/s": "-14.07838969279822",
    "weave at 5 m/s, real part": "-0.77534188219585",
    "weave at 5 m/s, imaginary part": "4.46486771378823",
    "capsize eigenvalue at 5 m/s": "-0.32286642900409",
}
"""Spectrum at 5 m/s as printed in Table 2 of the same paper."""
SPEEDS = {"weave": "4.29238253634111", "capsize": "6.02426201538837"}
"""Speeds at which weave becomes stable, and capsize unstable, as printed [m/s]."""

EXACT = {
    "castering eigenvalue at 5 m/s": "-14.07838969279825",
    "weave at 5 m/s, real part": "-0.77534188219584",
    "weave": "4.29238253634110",
    "capsize": "6.02426201538836",
}
"""Values from arithmetic of 40 digits, where the last printed digits are not right."""


def matrices(P: Mapping[str, ca.SX]) -> dict[str, ca.SX]:
    """M, C1, K0 and K2 in the parameters by name: appendix A."""
    w, c, s, k = P["w"], P["c"], ca.sin(P["lam"]), ca.cos(P["lam"])
    fork: tuple[Any, Any, Any] = (P["mH"], P["xH"], P["zH"])
    front: tuple[Any, Any, Any] = (P["mF"], w, -P["rF"])
    rear: tuple[Any, Any, Any] = (P["mR"], 0, -P["rR"])
    parts = (rear, (P["mB"], P["xB"], P["zB"]), fork, front)
    across = (P["IRxx"], P["IBxx"], P["IHxx"], P["IFxx"])
    mixed: tuple[Any, ...] = (0, P["IBxz"], P["IHxz"], 0)
    upward = (P["IRxx"], P["IBzz"], P["IHzz"], P["IFxx"])
    first_x, first_z = (sum(part[0] * part[i] for part in parts) for i in (1, 2))
    Txx = sum(i + m * z * z for i, (m, _, z) in zip(across, parts, strict=True))
    Txz = sum(i - m * x * z for i, (m, x, z) in zip(mixed, parts, strict=True))
    Tzz = sum(i + m * x * x for i, (m, x, _) in zip(upward, parts, strict=True))
    mass = fork[0] + front[0]  # the front assembly, which steers
    xA, zA = ((fork[0] * fork[i] + front[0] * front[i]) / mass for i in (1, 2))
    steered = list(zip(parts, across, mixed, upward, strict=True))[2:]
    Axx = sum(i + m * (z - zA) ** 2 for (m, _, z), i, _, _ in steered)
    Axz = sum(i - m * (x - xA) * (z - zA) for (m, x, z), _, i, _ in steered)
    Azz = sum(i + m * (x - xA) ** 2 for (m, x, _), _, _, i in steered)
    off = (xA - w - c) * k - zA * s  # of the front assembly from the steering axis
    Ass = mass * off**2 + Axx * s**2 + 2 * Axz * s * k + Azz * k**2
    Asx = -mass * off * zA + Axx * s + Axz * k
    Asz = mass * off * xA + Axz * s + Azz * k
    trail, SR, SF = c / w * k, P["IRyy"] / P["rR"], P["IFyy"] / P["rF"]
    ST, SA = SR + SF, mass * off + trail * first_x
    M01 = Asx + trail * Txz
    C01 = trail * ST + SF * k + Txz / w * k - trail * first_z
    return {
        "M": ca.vertcat(
            ca.horzcat(Txx, M01), ca.horzcat(M01, Ass + 2 * trail * Asz + trail**2 * Tzz)
        ),
        "C1": ca.vertcat(
            ca.horzcat(0, C01),
            ca.horzcat(-(trail * ST + SF * k), Asz / w * k + trail * (SA + Tzz / w * k)),
        ),
        "K0": ca.vertcat(ca.horzcat(first_z, -SA), ca.horzcat(-SA, -SA * s)),
        "K2": ca.vertcat(
            ca.horzcat(0, (ST - first_z) / w * k), ca.horzcat(0, (SA + SF * s) / w * k)
        ),
    }


def bicycle() -> Family:
    """The upright bicycle by its speed; every parameter stays a symbol."""
    P = {n: ca.SX.sym(n) for n in BENCHMARK}
    x, v = ca.SX.sym("x", 4), ca.SX.sym("v")
    found = matrices(P)
    stiffness = P["g"] * found["K0"] + v**2 * found["K2"]
    seen = {f"{n}_{i}{j}": found[n][i, j] for n in found for i in (0, 1) for j in (0, 1)}
    system = System.from_mass_matrix(
        "linear bicycle",
        x,
        ca.vertcat(v, *P.values()),
        mass=found["M"],
        forcing=-(v * found["C1"] @ x[2:] + stiffness @ x[:2]),
        unknowns=("d_lean_rate", "d_steer_rate"),
        rates={"lean": x[2], "steer": x[3]},
        states=("lean", "steer", "lean_rate", "steer_rate"),
        parameters=("v", *P),
        observables=lambda *_: seen,
        units={"v": "m/s"},
    )
    held = dict.fromkeys(system.states, 0.0)
    return Family(system, "upright", at=("v",), held=held, typical=BENCHMARK)


def of_spectrum(about: Source, family: Family, at: float, zeros: int = 0) -> list[BenchmarkRow]:
    """Rows of the four eigenvalues at 5 m/s.

    Parameters
    ----------
    about
        System and source.
    family
        The bicycle that runs straight.
    at
        Its member at 5 m/s.
    zeros
        Number of eigenvalues that must be zero by structure.

    Returns
    -------
    list of BenchmarkRow
    """
    found = spectrum(family, at=at, certify=True, **BENCHMARK)
    right = found.structural_zeros == zeros and found.eigenvalues.shape == (4,)
    values = found.eigenvalues if right else np.full(4, np.nan)
    numbers = [values[0].real, values[1].real, values[2].imag, values[3].real]
    return [
        compared(
            about,
            quantity,
            known,
            float(numbers[i]),
            origin=PUBLISHED,
            unit="1/s",
            reason="another number of eigenvalues",
            exact=EXACT.get(quantity, ""),
        )
        for i, (quantity, known) in enumerate(EIGENVALUES.items())
    ]


def of_speeds(
    about: Source, family: Family, brackets: Mapping[str, tuple[float, float]], scale: float
) -> list[BenchmarkRow]:
    """Rows of the speeds of weave and capsize.

    Parameters
    ----------
    about
        System and source.
    family
        The bicycle that runs straight.
    brackets
        Interval of the family's parameter around each speed, by name.
    scale
        Speed over the family's parameter [m].

    Returns
    -------
    list of BenchmarkRow
    """
    words = {
        "weave": "speed above which weave is stable",
        "capsize": "speed above which it capsizes",
    }
    return [
        at_threshold(
            about,
            threshold(family, *brackets[name], 5, **BENCHMARK),
            known,
            quantity=words[name],
            origin=PUBLISHED,
            unit="m/s",
            scale=scale,
            exact=EXACT[name],
        )
        for name, known in SPEEDS.items()
    ]


def linear_bicycle() -> list[BenchmarkRow]:
    """Rows of the linear bicycle: entries of its matrices, spectrum, weave and capsize.

    Returns
    -------
    list of BenchmarkRow
    """
    family = bicycle()
    seen = family.system.observe([0.0] * 4, [5.0, *BENCHMARK.values()])
    entries = [
        compared(
            LINEAR,
            name.replace("_", "[")[:-1] + f",{name[-1]}]",
            known,
            float(seen[name]),
            origin=PUBLISHED,
        )
        for name, known in ENTRIES.items()
    ]
    brackets = {"weave": (3.0, 5.0), "capsize": (5.0, 8.0)}
    return [*entries, *of_spectrum(LINEAR, family, 5.0), *of_speeds(LINEAR, family, brackets, 1.0)]
