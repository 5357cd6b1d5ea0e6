"""Large spectra with proofs: time of a call, ratio to `numpy.linalg.eig`, and width of the discs.

`eig` gives no bound and no verdict.  Each call starts from the matrices: a new family.  Then all
changes of verdict along a parameter, with what `boundaries` says of them.

Usage: python benchmarks/large.py [--few]
(few: without 1000 states)
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import scipy.sparse as sp
from timing import least

import stability as st

TURNS = 3


def dense(n: int) -> Any:
    random = np.random.default_rng(n)
    return random.normal(size=(n, n)) / np.sqrt(n) - 1.2 * np.eye(n)


def sparse(n: int, entries: int) -> Any:
    """A network: n rates of decay, and other entries at random places."""
    random = np.random.default_rng(n)
    found = sp.lil_array(sp.diags_array(-random.uniform(0.5, 2.0, n), shape=(n, n)))
    while found.nnz < entries:
        i, j = random.integers(0, n, 2)
        found[i, j] = found[i, j] or random.normal()
    return found


def chain(masses: int, family: bool) -> Any:
    """Masses between two walls, with dampers: as M, C and K, or from expressions."""
    stiff = sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(masses, masses))
    if not family:
        return st.linear(sp.eye_array(masses), 0.1 * stiff, stiff)
    x, p = ca.SX.sym("x", 2 * masses), ca.SX.sym("k")
    place, speed = x[:masses], x[masses:]
    force = p * ca.tanh(ca.diff(ca.vertcat(0, place, 0))) + ca.diff(ca.vertcat(0, speed, 0)) / 10
    names = [f"{v}{i}" for v in "qv" for i in range(masses)]
    rates = ca.vertcat(speed, ca.diff(force))
    system = st.System("chain", x, p, rates, states=names, parameters=("k",))
    return st.Family(system, "rest", at=("k",), held=dict.fromkeys(names, 0.0))


def turned(n: int) -> st.Family:
    """A dense matrix plus p times another one."""
    p = ca.SX.sym("p")
    more = np.random.default_rng([n, 1]).normal(size=(n, n)) / np.sqrt(n)
    return st.linear(ca.SX(ca.DM(dense(n))) + p * ca.SX(ca.DM(more)))


def driven(masses: int) -> st.Family:
    """Masses between two walls, with dampers, and a negative one at the first mass."""
    stiff = sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(masses, masses)).toarray()
    damping = ca.SX(ca.DM(0.1 * stiff))
    damping[0, 0] -= ca.SX.sym("p")
    return st.linear(np.eye(masses), ca.sparsify(damping), stiff)


def ring(cars: int) -> st.Family:
    """Cars that follow each other in a circle, by the optimal-velocity law."""
    x, p = ca.SX.sym("x", 2 * cars), ca.SX.sym("p")
    gap, speed = x[:cars], x[cars:]
    rates = ca.vertcat(ca.vertcat(speed[1:], speed[0]) - speed, p * (ca.tanh(gap - 2.25) - speed))
    gaps, speeds = ([f"{v}{i}" for i in range(cars)] for v in "hv")
    system = st.System("ring", x, p, rates, states=gaps + speeds, parameters=("p",))
    same, guess = dict.fromkeys(gaps, 2.0), dict.fromkeys(speeds, -0.25)
    return st.Family(system, "flow", at=("p",), held=same, unknown=guess, equations=speeds)


LINES: dict[str, tuple[Callable[[], st.Family], tuple[float, float]]] = {
    "dense, 20": (lambda: turned(20), (-1.0, 1.0)),
    "dense, 40": (lambda: turned(40), (-1.0, 1.0)),
    "driven chain, 40": (lambda: driven(20), (0.0, 2.0)),
    "ring of 20 cars, 40": (lambda: ring(20), (0.5, 4.0)),
}


def along(name: str) -> str:
    """The boundaries of a family along its parameter."""
    build, ends = LINES[name]
    found = st.boundaries(build(), axis=("p", *ends, 9))
    times = least({"call": lambda: st.boundaries(build(), axis=("p", *ends, 9))}, TURNS)
    state = "complete" if found.complete else "open"
    return f"{name:24} {times['call']:9.3f}  {len(found)} changes, {state}"


CASES: dict[str, tuple[int, Callable[[], Any], dict[str, float]]] = {
    "dense": (48, lambda: st.linear(dense(48)), {}),
    "chain from expressions": (48, lambda: chain(24, True), {"k": 1.0}),
    "dense ": (120, lambda: st.linear(dense(120)), {}),
    "chain from expressions ": (120, lambda: chain(60, True), {"k": 1.0}),
    "network, 405 entries": (270, lambda: st.linear(sparse(270, 405)), {}),
    "chain from M, C, K": (270, lambda: chain(135, False), {}),
    "dense  ": (1000, lambda: st.linear(dense(1000)), {}),
}


def line(name: str) -> str:
    """The figures of a case."""
    n, build, numbers = CASES[name]

    def call() -> st.Spectrum:
        return st.spectrum(build(), certify=True, **numbers)

    found = call()
    matrix = found.family.matrix(found.place.a, found.place.u, found.place.q)[0]
    times = least({"call": call, "eig": lambda: np.linalg.eig(matrix)}, TURNS)
    wide = (found.radius / np.abs(found.eigenvalues)).max()
    proved = found.verdict.word if found.certified else "undecided"
    return f"{n:6d}  {name:24} {times['call']:9.3f} {times['eig']:9.3f}  {proved:9} {wide:.1e}"


def main() -> None:
    print(f"{'states':>6}  {'':24} {'call [s]':>9} {'eig [s]':>9}  verdict   radius over |λ|")
    st.spectrum(st.linear(dense(3)), certify=True)  # imports
    for name, (n, _, _) in CASES.items():
        if n < 1000 or "--few" not in sys.argv:
            print(line(name), flush=True)
    print(f"boundaries, states {'':6} {'call [s]':>9}")
    for name in LINES:
        print(along(name), flush=True)


if __name__ == "__main__":
    main()
