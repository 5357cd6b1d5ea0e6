"""The bicycle: linear, from its 25 parameters; nonlinear, of four bodies and six constraints."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from ...spectra.spectrum import spectrum
from ...systems.family import Family
from ...systems.mechanics import mechanics
from ...systems.system import System
from .row import PUBLISHED, BenchmarkRow, Source, at_threshold, compared, threshold

LINEAR = Source(
    "linear bicycle", "Meijaard et al., Proc. R. Soc. A 463 (2007) 1955, Table 1", PUBLISHED
)
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
    entries = matrices(P)
    stiffness = P["g"] * entries["K0"] + v**2 * entries["K2"]
    seen = {f"{n}_{i}{j}": entries[n][i, j] for n in entries for i in (0, 1) for j in (0, 1)}
    system = System.from_mass_matrix(
        "linear bicycle",
        x,
        ca.vertcat(v, *P.values()),
        mass=entries["M"],
        forcing=-(v * entries["C1"] @ x[2:] + stiffness @ x[:2]),
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
    """Rows of the four eigenvalues at 5 m/s."""
    result = spectrum(family, at=at, certify=True, **BENCHMARK)
    right = result.structural_zeros == zeros and result.eigenvalues.shape == (4,)
    values = result.eigenvalues if right else np.full(4, np.nan)
    numbers = [values[0].real, values[1].real, values[2].imag, values[3].real]
    return [
        compared(
            about,
            quantity,
            reference,
            float(numbers[i]),
            unit="1/s",
            reason="another number of eigenvalues",
            exact=EXACT.get(quantity, ""),
        )
        for i, (quantity, reference) in enumerate(EIGENVALUES.items())
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
    """
    words = {
        "weave": "speed above which weave is stable",
        "capsize": "speed above which it capsizes",
    }
    return [
        at_threshold(
            about,
            words[name],
            reference,
            threshold(family, *brackets[name], 5, **BENCHMARK),
            unit="m/s",
            scale=scale,
            exact=EXACT[name],
        )
        for name, reference in SPEEDS.items()
    ]


def linear_bicycle() -> list[BenchmarkRow]:
    """Rows of the linear bicycle: entries of its matrices, spectrum, weave and capsize."""
    family = bicycle()
    seen = family.system.observe([0.0] * 4, [5.0, *BENCHMARK.values()])
    entries = [
        compared(
            LINEAR, name.replace("_", "[")[:-1] + f",{name[-1]}]", reference, float(seen[name])
        )
        for name, reference in ENTRIES.items()
    ]
    brackets = {"weave": (3.0, 5.0), "capsize": (5.0, 8.0)}
    return [*entries, *of_spectrum(LINEAR, family, 5.0), *of_speeds(LINEAR, family, brackets, 1.0)]


MOVING = Source(
    "nonlinear bicycle", "Basu-Mandal et al., Proc. R. Soc. A 463 (2007) 1983, Table 1", PUBLISHED
)
STRAIGHT = Source(
    "nonlinear bicycle, straight", "Meijaard et al., Proc. R. Soc. A 463 (2007) 1955", PUBLISHED
)
COORDINATES = ("x", "y", "z", "yaw", "lean", "pitch", "steer", "rear", "front")
"""Coordinates; axes x forward, y right, z down."""
GIVEN = {
    "z": "0.2440472102925",
    "theta": "0.0",
    "psi": "0.9501292851472",
    "phi": "3.1257073014894",
    "psif": "0.2311385135743",
    "xd": "-2.8069345714545",
    "yd": "-0.1480982396001",
    "zd": "0.1058778746261",
    "thetad": "0.7830033527065",
    "psid": "0.6068425835418",
    "phid": "-0.0119185528069",
    "psifd": "0.4859824687093",
    "betard": "8.9129896614890",
    "betafd": "8.0133620584155",
}
"""State of Table 1 as printed, as in DynamicistToolKit's `basu_table_one_input`."""
ACCELERATIONS = {
    "xdd": "-.5041626315047",
    "ydd": "-.3449706619454",
    "zdd": "-1.4604528332980",
    "thetadd": ".8353281706379",
    "psidd": "-7.8555281128244",
    "phidd": ".1205543897884",
    "psifdd": "-4.6198904039403",
    "betardd": "1.8472554144217",
    "betafdd": "2.4548072904550",
}
"""Accelerations of Table 1, as in `basu_table_one_output`."""
SIGNS = np.array([-1, 1, -1, -1, -1, -1, -1, 1, 1])
"""From the paper's velocities to those of the coordinates, in which wheels turn to the front."""
ROUNDING = 0.5e-13
"""Largest rounding of a number of the published state."""
DOWN = ca.SX([0, 0, 1])


def _turn(axis: int, angle: ca.SX) -> ca.SX:
    """Matrix of the rotation about a coordinate axis."""
    c, s, i, j = ca.cos(angle), ca.sin(angle), (axis + 1) % 3, (axis + 2) % 3
    matrix = ca.SX.eye(3)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def _inertia(xx: ca.SX, yy: ca.SX, zz: ca.SX, xz: ca.SX | float = 0.0) -> ca.SX:
    """Inertia matrix of a body that is symmetric about its xz plane."""
    return ca.vertcat(ca.horzcat(xx, 0, xz), ca.horzcat(0, yy, 0), ca.horzcat(xz, 0, zz))


def _contact(centre: ca.SX, axle: ca.SX, radius: ca.SX, spin: ca.SX) -> ca.SX:
    """Velocity of the lowest point of a wheel, from that of its centre, as a point of its rim."""
    across = DOWN - ca.dot(DOWN, axle) * axle
    return centre + ca.cross(spin, radius * across / ca.sqrt(ca.dot(across, across)))


def model(P: Mapping[str, ca.SX]) -> dict[str, Any]:
    """Coordinates, velocities, energies, and the velocities of both contact points."""
    Q = {n: ca.SX.sym(n) for n in COORDINATES}
    U = {n: ca.SX.sym(f"{n}_rate") for n in Q}
    q, u = ca.vertcat(*Q.values()), ca.vertcat(*U.values())
    heading = _turn(2, Q["yaw"])
    rolled = heading @ _turn(0, Q["lean"])
    frame = rolled @ _turn(1, Q["pitch"])
    tilt = _turn(1, P["lam"])
    fork = frame @ tilt @ _turn(2, Q["steer"]) @ tilt.T
    spin = U["yaw"] * DOWN + U["lean"] * heading[:, 0] + U["pitch"] * rolled[:, 1]
    fork_spin = spin + U["steer"] * (frame @ tilt)[:, 2]
    rear_spin = spin - U["rear"] * frame[:, 1]
    front_spin = fork_spin - U["front"] * fork[:, 1]
    rear = ca.vertcat(Q["x"], Q["y"], Q["z"])
    hub = ca.vertcat(0, 0, -P["rR"])  # the rear hub; the origin of the figures is below it
    body = rear + frame @ (ca.vertcat(P["xB"], 0, P["zB"]) - hub)
    pin = ca.vertcat(P["w"] + P["c"], 0, 0)  # where the steering axis meets the ground
    front, handle = (
        rear + frame @ (pin - hub) + fork @ (ca.vertcat(x, 0, z) - pin)
        for x, z in ((P["w"], -P["rF"]), (P["xH"], P["zH"]))
    )
    parts = (
        (P["mR"], rear, frame, rear_spin, _inertia(P["IRxx"], P["IRyy"], P["IRxx"])),
        (P["mB"], body, frame, spin, _inertia(P["IBxx"], P["IByy"], P["IBzz"], P["IBxz"])),
        (P["mH"], handle, fork, fork_spin, _inertia(P["IHxx"], P["IHyy"], P["IHzz"], P["IHxz"])),
        (P["mF"], front, fork, front_spin, _inertia(P["IFxx"], P["IFyy"], P["IFxx"])),
    )
    kinetic = potential = ca.SX(0)
    for mass, place, axes, omega, moments in parts:
        local = axes.T @ omega
        kinetic += (mass * ca.sumsqr(ca.jtimes(place, q, u)) + ca.dot(local, moments @ local)) / 2
        potential -= mass * P["g"] * place[2]
    rear_slip = _contact(ca.jtimes(rear, q, u), frame[:, 1], P["rR"], rear_spin)
    front_slip = _contact(ca.jtimes(front, q, u), fork[:, 1], P["rF"], front_spin)
    return {
        "q": q,
        "u": u,
        "kinetic": kinetic,
        "potential": potential,
        "velocity_constraints": ca.vertcat(rear_slip, front_slip),
    }


def _system(**choice: Any) -> System:
    p = {n: ca.SX.sym(n) for n in BENCHMARK}
    return mechanics(p=ca.vertcat(*p.values()), **model(p), name="nonlinear bicycle", **choice)


@cache
def straight() -> Family:
    """Straight running, by the rate of the rear wheel."""
    system = _system(
        independent=("lean_rate", "steer_rate", "rear_rate"),
        ignorable=("x", "y", "yaw", "rear", "front"),
    )
    held = dict.fromkeys((n for n in system.states if n != "rear_rate"), 0.0)
    held["z"] = -BENCHMARK["rR"]
    return Family(system, "straight", at=("rear_rate",), held=held, typical=BENCHMARK)


def accelerations() -> tuple[list[float], list[float]]:
    """The nine accelerations in the paper's symbols, and what the state's rounding can change."""
    system = _system()
    g = {name: float(digits) for name, digits in GIVEN.items()}
    place = [
        0.0,
        0.0,
        -g["z"],
        -g["theta"],
        math.pi / 2 - g["psi"],
        math.pi - g["phi"],
        -g["psif"],
        0.0,
        0.0,
    ]
    rates = SIGNS * [v for n, v in g.items() if n.endswith("d")]
    x, values = [*place, *rates], list(BENCHMARK.values())
    computed = SIGNS * system.rates(x, values)[9:]
    slopes = system.linearise(x, values)[9:]
    return computed.tolist(), (abs(slopes).sum(axis=1) * ROUNDING).tolist()


def nonlinear_bicycle() -> list[BenchmarkRow]:
    """Rows of the nonlinear bicycle: nine accelerations, spectrum, weave and capsize."""
    values, bounds = accelerations()
    rows = [
        compared(MOVING, f"acceleration {name}", reference, value, inputs=bound)
        for (name, reference), value, bound in zip(
            ACCELERATIONS.items(), values, bounds, strict=True
        )
    ]
    radius = BENCHMARK["rR"]
    brackets = {"weave": (10.0, 17.0), "capsize": (17.0, 25.0)}
    spectral = of_spectrum(STRAIGHT, straight(), 5.0 / radius, zeros=3)
    return [*rows, *spectral, *of_speeds(STRAIGHT, straight(), brackets, radius)]
