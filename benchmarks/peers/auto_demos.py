"""Ten demos of AUTO-07p: each special point that it labels, and the package's, with bounds.

AUTO continues the first family of equilibria of a demo with its own branch switching, from input
that `stability.export.auto_input` writes.  The package takes the same families by a quantity that
does not turn there, a state where the parameter turns, and lists every crossing of the imaginary
axis, with the proved number of unstable eigenvalues on both sides.  Branch points of AUTO at which
families meet are crossings of one of these families.  A point that only one of both has is said.

Models, first points and windows: AUTO-07p, demos ab, abc, pp2, pp3, enz (in mean and half
difference, where its symmetric family has no branch points of its equations), lrz, cusp, tor, fhn,
chu.
"""

from __future__ import annotations

import re
import subprocess
import tempfile
import time
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
from auto import auto_folder, missing

import stability as st

TYPES = {1: "branch point", 2: "fold", 3: "Hopf point", 5: "fold"}
"""Special points by AUTO's number."""
NEAR = 1e-4
"""Largest difference of two values of one point, over the window."""
BOX, SIDE = (-100.0, 100.0), 1e-5
"""States among which equilibria are counted, and the way from a value, over the value."""
TIME_LIMIT = 20.0
"""Longest run of AUTO [s]; what it wrote until then counts."""


@dataclass(frozen=True)
class Line:
    """A family by a quantity that does not turn, over a window of it."""

    at: str
    low: float
    high: float
    held: dict[str, float]
    guess: dict[str, float]


@dataclass(frozen=True)
class Demo:
    """A model with its window, and the families that AUTO reaches there."""

    name: str
    rates: dict[str, str]
    """Rate of each state."""
    parameters: dict[str, float]
    """The first one is free."""
    stop: float
    first: dict[str, float]
    """The first equilibrium; states left out are 0."""
    step: tuple[float, float]
    """First and largest step of the demo."""
    lines: tuple[Line, ...]

    @property
    def free(self) -> str:
        """The parameter that AUTO varies."""
        return next(iter(self.parameters))

    @property
    def system(self) -> st.System:
        """The model."""
        symbols = {n: ca.SX.sym(n) for n in (*self.rates, *self.parameters)}
        functions = {"exp": ca.exp, "atan": ca.atan, "pi": ca.pi}
        rhs = ca.vertcat(*[eval(v, functions, symbols) for v in self.rates.values()])
        x, p = (ca.vertcat(*[symbols[n] for n in v]) for v in (self.rates, self.parameters))
        names = {"states": tuple(self.rates), "parameters": tuple(self.parameters)}
        return st.System(self.name, x, p, rhs, **names)

    @property
    def fixed(self) -> dict[str, float]:
        """The other parameters."""
        return {n: v for n, v in self.parameters.items() if n != self.free}

    def family(self, line: Line) -> st.Family:
        """The family of a line."""
        system, solved = self.system, {n for n in self.rates if n not in (line.at, *line.held)}
        if not solved and line.at == self.free:
            return st.Family(system, "trivial", at=(self.free,), held=line.held)
        unknown = () if line.at == self.free else self.free
        guess = self.parameters | line.guess
        return system.steady(line.at, held=line.held, unknown=unknown, guess=guess)


def zero(*names: str) -> dict[str, float]:
    return dict.fromkeys(names, 0.0)


def uptake(x: str) -> str:
    """Rate of a reaction that its own substrate inhibits."""
    return f"({x}) / (1 + {x} + k * ({x})**2)"


REACTION = "p * (1 - u) * exp(w)"
DEMOS = (
    Demo(
        "ab",
        {"u": f"-u + {REACTION}", "w": f"-w + heat * {REACTION} - loss * w"},
        {"p": 0.0, "heat": 14.0, "loss": 3.0},
        0.25,
        {},
        (0.1, 0.05),
        (Line("w", 0.01, 3.4, {}, {"w": 1.0, "u": 0.3, "p": 0.1}),),
    ),
    Demo(
        "abc",
        {
            "x": "-x + d * (1 - x) * exp(z)",
            "y": "-y + d * exp(z) * (1 - x - s * y)",
            "z": "-z - b * z + d * heat * exp(z) * (1 - x + a * s * y)",
        },
        {"d": 0.0, "a": 1.0, "b": 1.55, "heat": 8.0, "s": 0.04},
        0.4,
        {},
        (0.02, 0.1),
        (Line("z", 0.01, 5.5, {}, {"z": 1.0, "x": 0.3, "y": 0.3, "d": 0.1}),),
    ),
    Demo(
        "pp2",
        {"x": "b * x * (1 - x) - x * y - q * (1 - exp(-c * x))", "y": "-y + e * x * y"},
        {"q": 0.0, "b": 3.0, "c": 5.0, "e": 3.0},
        1.0,
        {},
        (0.02, 0.06),
        (
            Line("q", -0.1, 1.0, zero("x", "y"), {}),
            Line("x", 0.01, 1.0, zero("y"), {"x": 0.5, "q": 0.5}),
            Line("q", 0.0, 1.0, {}, {"x": 0.33, "y": 1.5, "q": 0.5}),
        ),
    ),
    Demo(
        "pp3",
        {
            "x": "x * (1 - x) - d * x * y",
            "y": "-b * y + d * x * y - e * y * z - q * (1 - exp(-f * y))",
            "z": "-c * z + e * y * z",
        },
        {"q": 0.0, "b": 0.25, "c": 0.5, "d": 4.0, "e": 3.0, "f": 5.0},
        1.0,
        {"x": 1.0},
        (0.01, 0.02),
        (
            Line("q", 0.0, 1.0, {"x": 1.0, "y": 0.0, "z": 0.0}, {}),
            Line("y", 0.01, 0.24, zero("z"), {"y": 0.1, "x": 0.6, "q": 0.3}),
            Line("y", -0.2, -0.01, zero("z"), {"y": -0.1, "x": 1.4, "q": 0.8}),
            Line("q", 0.0, 1.0, {}, {"x": 0.333, "y": 0.1667, "z": 0.2, "q": 0.02}),
        ),
    ),
    Demo(
        "enz",
        {
            "m": f"s - m - r / 2 * ({uptake('m + d')} + {uptake('m - d')})",
            "d": f"-3 * d - r / 2 * ({uptake('m + d')} - {uptake('m - d')})",
        },
        {"s": 0.0, "r": 100.0, "k": 1.0},
        60.0,
        {},
        (0.1, 0.25),
        (
            Line("m", 0.01, 20.0, zero("d"), {"m": 3.0, "s": 26.0}),
            Line("m", 1.18, 4.95, {}, {"m": 3.0, "d": 2.446, "s": 25.4}),
            Line("d", 0.02, 3.6, {}, {"d": 1.254, "m": 4.5, "s": 22.7}),
        ),
    ),
    Demo(
        "lrz",
        {"x": "s * (y - x)", "y": "r * x - y - x * z", "z": "x * y - b * z"},
        {"r": 0.0, "b": 8 / 3, "s": 10.0},
        30.0,
        {},
        (0.1, 5.0),
        (
            Line("r", 0.0, 30.0, zero("x", "y", "z"), {}),
            Line("z", 0.01, 29.0, {}, {"z": 20.0, "x": 7.3, "y": 7.3, "r": 21.0}),
        ),
    ),
    Demo(
        "cusp",
        {"x": "m + l * x - x**3"},
        {"m": 0.0, "l": 1.0},
        2.0,
        {},
        (0.01, 0.1),
        (Line("x", -1.5, 1.5, {}, {"x": 0.1, "m": 0.0}),),
    ),
    Demo(
        "tor",
        {
            "x": "(-(b + n) * x + b * y - f * x**3 + h * (y - x)**3) / r",
            "y": "b * x - (b + g) * y - z - h * (y - x)**3",
            "z": "y",
        },
        {"n": -0.9, "b": 0.5, "g": -0.6, "r": 0.6, "f": 0.328578, "h": 0.933578},
        -0.4,
        {},
        (0.001, 0.01),
        (
            Line("n", -0.9, -0.4, zero("x", "y", "z"), {}),
            Line("x", 0.01, 1.2, {}, {"x": 0.5, "z": 0.3, "n": -0.6}),
        ),
    ),
    Demo(
        "fhn",
        {"x": "c * (x - x**3 / 3 + y)", "y": "-(x - a + b * y) / c"},
        {"a": 0.0, "b": 0.8, "c": 3.0},
        1.0,
        {},
        (0.01, 0.05),
        (Line("x", -0.01, 1.6, {}, {"x": 0.3, "y": -0.3, "a": 0.1}),),
    ),
    Demo(
        "chu",
        {
            "x": "a * (y - h * x - (g - h) * ((x + 1) * atan(k * (x + 1))"
            " - (x - 1) * atan(k * (x - 1))) / pi)",
            "y": "x - y + z",
            "z": "-b * y",
        },
        {"a": -1.0, "b": 14.3, "k": 10.0, "g": -1 / 7, "h": 2 / 7},
        10.0,
        {},
        (0.01, 0.1),
        (
            Line("a", -1.0, 10.0, zero("x", "y", "z"), {}),
            Line("a", 1.0, 10.0, {"y": 0.0}, {"x": 1.6, "z": -1.6, "a": 5.0}),
        ),
    ),
)


@dataclass(frozen=True)
class Point:
    """A special point of the package."""

    value: float
    """The free parameter."""
    at: str
    """The quantity that names it, its value and bound, and what crosses."""
    hopf: bool


def listed(demo: Demo) -> tuple[list[Point], list[str]]:
    """Crossings of all lines by the free parameter, and what stays open."""
    points, left = [], []
    for line in demo.lines:
        family = demo.family(line)
        fixed = {n: v for n, v in demo.fixed.items() if n != line.at}
        axis = (line.at, line.low, line.high, 40)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            crossings = st.boundaries(family, axis=axis, every=True, **fixed)
        left += [f"{line.at} from {p.low:.6g} to {p.high:.6g}" for p in crossings.unresolved]
        values = [c.value for c in crossings]
        if values and line.at != demo.free:
            values = st.spectrum(family, at=values, **fixed).values[demo.free].tolist()
        for c, value in zip(crossings, values, strict=True):
            sides = f"{c.unstable_below} → {c.unstable_above} unstable"
            place = f"{line.at} = {c.value:.15g} ± {c.error:.0e}, {sides}"
            points.append(Point(value, place, "flutter" in c.crossing.word))
    low, high = sorted((demo.parameters[demo.free], demo.stop))
    inside = (p for p in points if low <= p.value <= high)
    return sorted(inside, key=lambda p: p.value), left


def labelled(demo: Demo, folder: Path) -> tuple[list[tuple[str, float]], str]:
    """AUTO's special points as (kind, value), and how it failed."""
    free, system = demo.free, demo.system
    first = {n: demo.first.get(n, 0.0) for n in demo.rates}
    family = st.Family(system, demo.name, at=(free,), held=first)
    start = demo.parameters[free]
    given = {"free": free, "start": start, "stop": demo.stop, **demo.fixed}
    st.export.auto_input(family, folder, name="demo", overwrite=True, **given)
    constants = (folder / "c.demo").read_text()
    constants = re.sub(r"MXBF = 0", "MXBF = 10", constants)
    first_step, largest = demo.step
    steps = {"NMX": 1000, "DS": first_step, "DSMIN": 1e-3 * first_step, "DSMAX": largest}
    for name, value in steps.items():
        constants = re.sub(rf"\b{name} = [^,\n]+", f"{name} = {value!r}", constants)
    (folder / "fort.2").write_text(constants)
    library = auto_folder() / "lib"
    objects = [str(o) for o in sorted(library.glob("*.o"))]
    link = ["gfortran", "-O2", "-fopenmp", "demo.o", *objects, f"-L{library}", "-lauto_c"]
    include = f"-I{library.parent / 'include'}"
    for command in (["gcc", "-O2", "-w", include, "-c", "demo.c"], [*link, "-o", "demo"]):
        subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    failure = ""
    try:
        subprocess.run(["./demo"], cwd=folder, check=True, capture_output=True, timeout=TIME_LIMIT)
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
        failure = f"; AUTO: {type(error).__name__}"
    rows = [line.split() for line in (folder / "fort.7").read_text().splitlines()]
    points = [r for r in rows if len(r) > 5 and r[0] != "0" and r[1].lstrip("-").isdigit()]
    found = [(TYPES[int(r[2])], float(r[4])) for r in points if int(r[2]) in TYPES]
    low, high = sorted((start, demo.stop))
    inside = [f for f in found if low <= f[1] <= high]
    return inside, failure


def counted(demo: Demo, value: float) -> str:
    """Equilibria in a box on both sides of a fold that AUTO alone has; a fold changes them by 2."""
    box = dict.fromkeys(demo.rates, BOX)
    sides = []
    for share in (1 - SIDE, 1 + SIDE):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = demo.system.equilibria(box, **demo.fixed, **{demo.free: value * share})
        sides.append(f"{len(found.states)}{'' if found.complete else ' or more'}")
    return f"not listed: {sides[0]} equilibria below, {sides[1]} above, within ±{BOX[1]:g}"


def report(demo: Demo) -> tuple[int, int, int]:
    """Print one demo; points of both, of AUTO alone, of the package alone."""
    begin = time.perf_counter()
    ours, left = listed(demo)
    taken = time.perf_counter() - begin
    with tempfile.TemporaryDirectory() as name:
        theirs, failure = labelled(demo, Path(name))
    print(f"\n{demo.name}: {len(demo.lines)} families, {taken:.1f} s {failure}")
    width, matched, both = abs(demo.stop - demo.parameters[demo.free]), set(), 0
    for kind, value in sorted(set(theirs), key=lambda t: t[1]):
        near = [
            i
            for i, p in enumerate(ours)
            if abs(p.value - value) <= NEAR * width and p.hopf == (kind == "Hopf point")
        ]
        matched |= set(near)
        both += bool(near)
        print(f"  AUTO {kind:13s} {demo.free} = {value:<14.10g}", end="")
        print(
            *[f"{ours[i].value:.12g} ({ours[i].at})" for i in near] or [counted(demo, value)],
            sep="; ",
        )
    alone = [p for i, p in enumerate(ours) if i not in matched]
    for p in alone:
        print(f"  package alone      {demo.free} = {p.value:<14.10g}({p.at})")
    for piece in left:
        print(f"  open: {piece}")
    return both, len(set(theirs)) - both, len(alone)


def main() -> None:
    problem = missing()
    if problem:
        print(problem)
        return
    counts: Any = [report(demo) for demo in DEMOS]
    both, theirs, ours = (sum(c) for c in zip(*counts, strict=True))
    print(f"\n{both} points of both, {theirs} of AUTO alone, {ours} of the package alone")


if __name__ == "__main__":
    main()
