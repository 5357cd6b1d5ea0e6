"""Whole calls as users make them, next to what a user would write instead: time and error."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.types import Floats
from ..jobs.measured_cells import Cell, Task
from ..maps.stability_map import stability_map
from .chart import Line
from .cost import least, timed
from .motion.chart import judged
from .motion.drivers import MotionAnswer as Motion
from .motion.drivers import RungeKutta45, driver
from .motion.reference_motions import scene
from .spectrum.chart import bisected, errors, exact_edge, proved
from .spectrum.points import EDGES, Points, points_of
from .spectrum.routes import SpectrumAnswer, route

AD = "ad-1e-9"
"""The route that people take: the Jacobian by automatic differentiation, eigenvalues by LAPACK."""


@dataclass(frozen=True)
class Way:
    """One way to an answer."""

    title: str
    """What is called."""
    call: Callable[[Any], Any]
    """Function from the size of a question to an answer."""
    own: bool = False
    """Whether it is the package's own call."""


@dataclass(frozen=True)
class TimedQuestion:
    """What is asked, in several sizes, and the ways to it by name."""

    title: str
    """What is asked, and its sizes."""
    sizes: tuple[Any, ...]
    """Sizes: numbers of cells or members, boundaries, motions."""
    error: Callable[[Any, Any], float]
    """Function from a size and an answer to the largest relative error; NaN without an answer."""
    ways: Mapping[str, Way]
    """Ways by name."""


# --- map ---


AT, MU = (1.1, 4.0), (0.1, 2.0)
"""Ends of the axes; no cell lies on the static boundary at 2."""


def _grid(side: int) -> Points:
    at, mu = np.meshgrid(np.linspace(*AT, side), np.linspace(*MU, side))
    k = np.full(at.size, 0.25)
    return Points("spinning", "viscous", k, mu.ravel(), at.ravel())


def _map(side: int) -> Floats:
    x, y = ("at", *AT, side), ("mu", *MU, side)
    abscissa: Floats = stability_map(
        "spinning", x=x, y=y, contact="viscous"
    ).abscissa.values.ravel()
    return abscissa


def _growth(side: int) -> Floats:
    abscissa = route(AD).answer(_grid(side)).abscissa
    assert abscissa is not None
    return abscissa


def _error_of_growth(side: int, abscissa: Floats) -> float:
    """The largest error at 16 cells across the map."""
    some = np.unique(np.linspace(0, side**2 - 1, 16).astype(int))
    codes = np.zeros(len(some), dtype=np.int8)
    _, off = errors(_grid(side)[some], SpectrumAnswer(codes, abscissa=abscissa[some]))
    assert off is not None
    return float(off.max())


# --- spectrum ---


def _members(count: int) -> Points:
    [first, *_] = points_of("open")
    return first[:count]


def _error_of_eigenvalues(count: int, answer: SpectrumAnswer) -> float:
    off, _ = errors(_members(count), answer)
    assert off is not None
    return float(off.max())


# --- boundaries ---


PLACES = {EDGES[i][0]: EDGES[i] for i in (0, 2, 4)}
"""Boundaries by family."""


def _boundary(name: str) -> float:
    changes = proved(PLACES[name], *PLACES[name][4:], 60)
    return changes[0].value if len(changes) == 1 else math.nan


def _bisection(name: str) -> float:
    """60 values, then bisection where the verdict first changes."""
    low, high = PLACES[name][4:]
    values = np.linspace(low, high, 60)
    for a, b in zip(values[:-1], values[1:], strict=True):
        if (value := bisected(route(AD), PLACES[name], a, b)) is not None:
            return value
    return math.nan


def _error_of_boundary(name: str, value: float) -> float:
    exact, rest = exact_edge(*PLACES[name])
    return abs((value - exact) - rest) / exact


# --- simulate ---


def _solved(**options: Any) -> Callable[[str], Motion]:
    return lambda name: RungeKutta45().solved(scene(name), scene(name).asked, ends=True, **options)


def _simulated(name: str) -> Motion:
    mine = driver("simulate")
    return mine.run(scene(name), scene(name).asked, mine.usual)


def _error_of_motion(name: str, motion: Motion) -> float:
    path = judged(scene(name), motion)["path"]
    return math.nan if path is None else float(path)


EIGVALS = "Jacobian by AD at all cells or members, then numpy.linalg.eigvals"
QUESTIONS: dict[str, TimedQuestion] = {
    "map": TimedQuestion(
        "map: 10², 40², 160² cells",
        (10, 40, 160),
        _error_of_growth,
        {
            "stability_map": Way(
                "stability_map(): verdicts, rates, curves, proved", _map, own=True
            ),
            "eigvals": Way(EIGVALS, _growth),
        },
    ),
    "spectrum": TimedQuestion(
        "spectrum: 1, 4, 16 members",
        (1, 4, 16),
        _error_of_eigenvalues,
        {
            "spectrum": Way(
                "spectrum()", lambda n: route("spectrum").answer(_members(n)), own=True
            ),
            "eigvals": Way(EIGVALS, lambda n: route(AD).answer(_members(n))),
        },
    ),
    "boundaries": TimedQuestion(
        "boundaries: rolling, spinning, tumbling",
        tuple(PLACES),
        _error_of_boundary,
        {
            "boundaries": Way("boundaries()", _boundary, own=True),
            "bisection": Way("eigvals at 60 values, then bisection", _bisection),
        },
    ),
    "simulate": TimedQuestion(
        "simulate: gentle, lift-off, stiff",
        ("gentle", "lift-off", "stiff-300"),
        _error_of_motion,
        {
            "simulate": Way("simulate(): checked by neighbours", _simulated, own=True),
            "RK45": Way("solve_ivp with its defaults, an event", _solved()),
            "LSODA": Way(
                "solve_ivp (LSODA, 1e-9), an event", _solved(method="LSODA", rtol=1e-9, atol=1e-9)
            ),
        },
    ),
}
"""Every question by name."""
WAYS = {name: way for asked in QUESTIONS.values() for name, way in asked.ways.items()}
"""Every way by name."""


def tasks() -> list[list[Task]]:
    """One cell for each way, in a process of its own, so that its first call is the first."""
    return [
        [Task(f"calls/{question}/{way}", measure, (question, way), 60.0)]
        for question, asked in QUESTIONS.items()
        for way in asked.ways
    ]


def measure(question: str, way: str) -> dict[str, Any]:
    """One cell: a way to a question in all sizes.

    Returns
    -------
    dict
        first: seconds of the first call; along the sizes: size, error, seconds (every repeat).
    """
    asked = QUESTIONS[question]
    call = asked.ways[way].call
    out: dict[str, Any] = {"first": None, "size": [], "error": [], "seconds": []}
    for size in asked.sizes:
        start = time.perf_counter()
        answer = call(size)
        if out["first"] is None:
            out["first"] = time.perf_counter() - start
        error = asked.error(size, answer)
        out["size"].append(size)
        out["error"].append(None if math.isnan(error) else float(error))
        out["seconds"].append(timed(lambda n=size: call(n), least=2, most=9, budget=0.5))  # type: ignore[misc]
    return out


def rows(cells: Mapping[str, Cell]) -> list[Line]:
    """A line for each way and size that is measured."""
    lines = []
    for question, asked in QUESTIONS.items():
        for name, way in asked.ways.items():
            cell = cells.get(f"calls/{question}/{name}")
            value = (cell and cell.value) or {"size": []}
            lines += [
                {
                    "question": question,
                    "way": name,
                    "own": way.own,
                    "size": size,
                    "error": value["error"][i],
                    "time [s]": least(value["seconds"][i]),
                    "first [s]": value["first"],
                }
                for i, size in enumerate(value["size"])
            ]
    return lines
