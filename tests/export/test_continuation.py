"""Input of AUTO and BifurcationKit: compiled or read, against the graph, and continued here."""

import ctypes
import math
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from julia_reader import Reader, function_value
from programs import needed
from scipy.optimize import brentq

import stability as st
from stability.cli.commands import main
from stability.export.to_continuation import places

HEADER = """\
typedef int integer; typedef double doublereal;
#include <stdio.h>
#include <math.h>
"""
"""What AUTO's own header says, as far as an equations file needs it."""


def spinning() -> st.Family:
    return st.disk_family("spinning", "viscous")


def tumbling() -> st.Family:
    return st.disk_family("tumbling", "viscous")


def oscillator() -> st.Family:
    """Van der Pol's, with a place on a plane that no rate holds."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    rates = ca.vertcat(x[1], (p[0] - x[0] ** 2) * x[1] - p[1] * x[0], x[0] + 1)
    system = st.System(
        "oscillator", x, p, rates, states=("q", "v", "place"), parameters=("gain", "spring")
    )
    return st.Family(system, "rest", at=("gain",), held={"q": 0.0, "v": 0.0})


CASES: dict[str, tuple[Any, dict[str, Any]]] = {
    "spinning by phi_dot": (
        spinning,
        {"free": "phi_dot", "start": 5.0, "stop": 1.8, "k": 0.25, "mu": 0.8},
    ),
    "spinning by mu": (
        spinning,
        {"free": "mu", "start": 0.3, "stop": 1.5, "k": 0.25, "phi_dot": 2.6},
    ),
    "tumbling by theta": (
        tumbling,
        {"free": "theta", "start": 1.3, "stop": 0.3, "k": 0.5, "mu": 0.8},
    ),
    "oscillator": (oscillator, {"free": "gain", "start": -1.0, "stop": 1.0, "spring": 2.0}),
}


class Compiled:
    """AUTO's equations file, compiled with a header of its types, called by ctypes."""

    def __init__(self, folder: Path) -> None:
        [source] = folder.glob("*.c")
        [self.constants] = folder.glob("c.*")
        (folder / "auto_f2c.h").write_text(HEADER)
        words = "-O1 -Wall -Wno-unused -Werror -I. -shared -fPIC".split()
        command = [needed("gcc", "cc"), *words, source.name, "-lm", "-o", "problem.so"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        self.library = ctypes.CDLL(str(folder / "problem.so"))
        words = self.constants.read_text()
        self.ndim = int(re.search(r"NDIM = (\d+)", words)[1])  # type: ignore[index]
        self.par_names = {
            n: int(i)
            for i, n in re.findall(r"(\d+): '(\w+)'", words.split("parnames")[1].split("}")[0])
        }
        self.free = re.search(r"ICP = \['(\w+)'\]", words)[1]  # type: ignore[index]
        self.stop = float(re.search(r"UZSTOP = \{'\w+': (.*)\}", words)[1])  # type: ignore[index]
        self.u, self.par = np.zeros(self.ndim), np.zeros(36)
        self.library.stpnt.argtypes = [
            ctypes.c_int,
            ctypes.c_double,
            ctypes.c_void_p,
            ctypes.c_void_p,
        ]
        self.library.stpnt(self.ndim, 0.0, self.u.ctypes.data, self.par.ctypes.data)

    def at(self, u: np.ndarray, par: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """f, ∂f/∂u and ∂f/∂par."""
        n = self.ndim
        f, by_u, by_par = np.zeros(n), np.zeros((n, n), order="F"), np.zeros((n, 36), order="F")
        u, par = np.ascontiguousarray(u), np.ascontiguousarray(par)
        pointers = [ctypes.c_void_p(a.ctypes.data) for a in (u, par, f, by_u, by_par)]
        failed = self.library.func(n, pointers[0], None, pointers[1], 2, *pointers[2:])
        assert failed == 0
        return f, by_u, by_par

    def equilibrium(self, c: float, guess: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """State and Jacobian of the equilibrium at a value of the free parameter, by Newton."""
        par = self.par.copy()
        par[self.par_names[self.free] - 1] = c
        u = guess.copy()
        for _ in range(30):
            f, by_u, _ = self.at(u, par)
            step = np.linalg.solve(by_u, f)
            u = u - step
            if abs(step).max() < 1e-14:
                break
        return u, self.at(u, par)[1]


def made(name: str, folder: Path) -> tuple[st.Family, dict[str, Any], Compiled]:
    make, given = CASES[name]
    family = make()
    st.auto_input(family, folder, **given)
    return family, given, Compiled(folder)


@pytest.mark.outside
@pytest.mark.parametrize("name", CASES)
def test_the_problem_has_the_members_and_their_eigenvalues(name: str, tmp_path: Path) -> None:
    """Newton on the compiled equations, against the family's members and its matrix by NumPy."""
    family, given, problem = made(name, tmp_path)
    names = (*family.at, *family.parameters)
    keep = [i for i, n in enumerate(family.system.states) if n not in family.left_out]
    assert abs(problem.at(problem.u, problem.par)[0]).max() < 1e-12
    guess = problem.u
    for c in np.linspace(given["start"], given["stop"], 9):
        guess, slopes = problem.equilibrium(c, guess)
        values = given | {given["free"]: c}
        a, q = [values[n] for n in family.at], [values[n] for n in family.parameters]
        whole = family.member(a, q)
        assert guess == pytest.approx(whole[keep], abs=1e-9)
        own = [values[n] for n in family.system.parameters]
        wanted = np.linalg.eigvals(family.system.linearise(whole, own)[np.ix_(keep, keep)])
        moved = sum(n in family.system.states for n in family.at)
        found = np.linalg.eigvals(slopes)
        zeros = np.argsort(abs(wanted))[:moved]
        wanted[zeros] = -1.0  # the tangent's zero, and no other, has moved
        for value in wanted:
            nearest = np.argmin(abs(found - value))
            assert abs(found[nearest] - value) < 1e-7, (value, found)
            found = np.delete(found, nearest)
    assert names


@pytest.mark.outside
@pytest.mark.parametrize("name", CASES)
def test_derivatives_are_those_of_the_rates(name: str, tmp_path: Path) -> None:
    """Exact derivatives against central differences, at states off the family."""
    _, _, problem = made(name, tmp_path)
    rng, h = np.random.default_rng(5), 1e-6
    for _ in range(3):
        u = problem.u + rng.uniform(-0.05, 0.05, problem.ndim)
        par = problem.par * (1 + rng.uniform(-0.05, 0.05, 36))
        _, by_u, by_par = problem.at(u, par)
        for i in range(problem.ndim):
            e = h * np.eye(problem.ndim)[i]
            slope = (problem.at(u + e, par)[0] - problem.at(u - e, par)[0]) / (2 * h)
            assert by_u[:, i] == pytest.approx(slope, abs=1e-7 * max(1, abs(slope).max()))
        for place in problem.par_names.values():
            e = h * np.eye(36)[place - 1]
            slope = (problem.at(u, par + e)[0] - problem.at(u, par - e)[0]) / (2 * h)
            assert by_par[:, place - 1] == pytest.approx(slope, abs=1e-6)


@pytest.mark.outside
@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["spinning by phi_dot", "tumbling by theta", "oscillator"])
def test_a_continuation_of_the_problem_meets_the_boundaries(name: str, tmp_path: Path) -> None:
    """Growth along the compiled problem changes sign where `boundaries` proves a change."""
    family, given, problem = made(name, tmp_path)
    grid = np.linspace(given["start"], given["stop"], 60)
    guess, signs, where = problem.u, [], []
    for c in grid:
        guess, slopes = problem.equilibrium(c, guess)
        values = np.linalg.eigvals(slopes)
        signs.append(values.real.max() > 0)
        where.append(guess)
    own = {n: v for n, v in given.items() if n in family.parameters}
    low, high = sorted((given["start"], given["stop"]))
    if name == "oscillator":
        own = {"spring": 2.0}
    edges = sorted(
        p.value for p in st.boundaries(family, axis=(given["free"], low, high, 20), **own)
    )
    found = []
    for i in np.flatnonzero(np.diff(signs)):

        def growth(c: float, start: np.ndarray = where[i]) -> float:
            return float(np.linalg.eigvals(problem.equilibrium(c, start)[1]).real.max())

        found.append(brentq(growth, grid[i], grid[i + 1], xtol=1e-12))
    assert sorted(found) == pytest.approx(edges, rel=1e-8, abs=1e-8)
    assert edges


@pytest.mark.long
def test_julias_lines_have_the_same_values(tmp_path: Path) -> None:
    """The functions of the Julia file, read by Julia's grammar, against the compiled C."""
    for name in CASES:
        make, given = CASES[name]
        _, _, problem = made(name, tmp_path / name / "auto")
        folder = st.bifurcationkit_input(make(), tmp_path / name / "julia", **given)
        [file] = folder.glob("*.jl")
        words = file.read_text()
        state = np.array(eval(re.search(r"u0 = (\[.*?\])", words)[1]))  # type: ignore[index]
        assert state == pytest.approx(problem.u, rel=1e-15)
        numbers = dict(
            re.findall(r"(\w+) = ([-\d.e]+)[,)]", re.search(r"\npar = \((.*)\)\n", words)[0])
        )  # type: ignore[index]
        par = {n: float(v) for n, v in numbers.items()}
        rng = np.random.default_rng(2)
        u = state + rng.uniform(-0.05, 0.05, len(state))
        f, by_u, _ = problem.at(u, problem.par)
        assert function_value(words, "rates", u, par) == pytest.approx(f, rel=1e-12, abs=1e-12)
        slopes = function_value(words, "jacobian", u, par)
        assert np.array(slopes) == pytest.approx(by_u, rel=1e-11, abs=1e-11)
        assert f"(@optic _.{given['free']})" in words


def test_the_reader_of_julia_has_julias_rules() -> None:
    """A power binds tighter than a sign and from the right; places start at 1; names are known."""
    names = {"u": [7.0, 8.0], "p": {"mu": 0.5}}
    for text, value in (
        ("-2.0 ^ 2", -4.0),
        ("2.0 ^ 3.0 ^ 2", 512.0),
        ("(-2.0) ^ 2", 4.0),
        ("u[2] - u[1] - 1.0", 0.0),
        ("6 / 2 / 3", 1.0),
        ("atan(1.0, 0.0)", math.pi / 2),
        ("p.mu * -2.0", -1.0),
        ("2.0 ^ -1.0", 0.5),
    ):
        assert Reader(text, names).whole() == pytest.approx(value), text
    for wrong in ("u[0]", "u[3]", "t1 + 1", "2.0 3.0", "u[1]]", "2 +"):
        with pytest.raises((AssertionError, KeyError, IndexError)):
            Reader(wrong, names).whole()


def test_places_that_auto_uses_itself_stay_free() -> None:
    assert places(12) == [*range(1, 10), 15, 16, 17]


def test_many_parameters_keep_their_places(tmp_path: Path) -> None:
    """Eleven parameters: values and derivatives land at the places of parnames."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 11)
    powers = sum((i + 1) * p[i] for i in range(11))
    system = st.System(
        "many",
        x,
        p,
        ca.vertcat(x[1], -x[0] + powers - x[1]),
        states=("q", "v"),
        parameters=tuple(f"a{i}" for i in range(11)),
    )
    family = st.Family(
        system, "rest", at=("a0",), held={"v": 0.0}, unknown={"q": 1.0}, equations=("v",)
    )
    given = {f"a{i}": 0.1 * i for i in range(1, 11)}
    st.auto_input(family, tmp_path, free="a0", start=1.0, stop=2.0, **given)
    problem = Compiled(tmp_path)
    assert problem.u == pytest.approx([1 + sum(0.1 * i * (i + 1) for i in range(1, 11)), 0])
    by_par = problem.at(problem.u, problem.par)[2]
    for i in range(11):
        assert by_par[1, problem.par_names[f"a{i}"] - 1] == pytest.approx(i + 1)
    assert np.count_nonzero(by_par) == 11


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"free": "speed"}, "free is 'speed'; known are phi_dot, k, mu"),
        ({"free": "phi_dot", "k": 0.25}, "mu has no value"),
        ({"free": "phi_dot", "k": 0.25, "mu": 0.3, "g": 1.0}, "g is no parameter to give"),
        ({"free": "phi_dot", "k": 0.25, "mu": "x"}, "mu is 'x'; give one finite number"),
        ({"free": "phi_dot", "k": 0.25, "mu": 0.3, "stop": 5.0}, "give two finite numbers"),
    ],
)
def test_bad_input_is_refused(given: dict[str, Any], said: str, tmp_path: Path) -> None:
    with pytest.raises(st.StabilityError, match=re.escape(said)):
        st.auto_input(spinning(), tmp_path / "x", **({"start": 5.0, "stop": 1.8} | given))
    assert not (tmp_path / "x").exists()


def test_equilibria_that_are_not_isolated_are_refused(tmp_path: Path) -> None:
    """Viscous rolling has a second zero by structure, which no parameter names."""
    rolling = st.disk_family("rolling", "viscous")
    for write in (st.auto_input, st.bifurcationkit_input):
        with pytest.raises(st.StabilityError, match="1 more eigenvalue 0 by structure.*boundaries"):
            write(rolling, tmp_path / "x", free="omega3", start=1.0, stop=2.0, k=0.25, mu=0.3)
    # the remedy that the sentence names: flutter of upright rolling, for k = 1/4
    [point] = st.boundaries(rolling, axis=("omega3", 1, 2, 9), k=0.25, mu=0.3)
    assert point.value == pytest.approx(2**0.5, abs=1e-12)


def test_the_commands_write_their_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rest = ["spinning", "--axis", "phi_dot:5:1.8", "--set", "k=1/4", "--set", "mu=0.8"]
    for word, names in (
        ("auto", ["c.spinning", "spinning.c"]),
        ("bifurcationkit", ["spinning.jl"]),
    ):
        out = tmp_path / word
        assert main(["export", word, *rest, "--out", str(out)]) == 0
        assert sorted(p.name for p in out.iterdir()) == names
    st.auto_input(spinning(), tmp_path / "own", **CASES["spinning by phi_dot"][1])
    assert (tmp_path / "own" / "spinning.c").read_bytes() == (
        tmp_path / "auto" / "spinning.c"
    ).read_bytes()
    assert main(["export", "auto", "spinning", "--out", str(tmp_path / "y")]) == 2
    assert "needs --axis NAME:START:STOP" in capsys.readouterr().err


def test_the_command_takes_the_numbers_of_a_body(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    family = st.Torus(0.2).family("spinning", "viscous")
    rest = ["--set", "phi_dot=3", "--out"]
    start = ["export", "auto", "spinning", "--body", "torus"]
    known = st.auto_input(
        family, tmp_path / "a", free="mu", start=0.1, stop=2.0, tube=0.2, phi_dot=3.0
    )
    mu = ["--tube", "0.2", "--axis", "mu:0.1:2"]
    assert main([*start, *mu, *rest, str(tmp_path / "b")]) == 0
    known_tube = st.auto_input(
        family, tmp_path / "c", free="tube", start=0.1, stop=0.3, mu=0.8, phi_dot=3.0
    )
    tube = ["--axis", "tube:0.1:0.3", "--set", "mu=0.8"]
    assert main([*start, *tube, *rest, str(tmp_path / "d")]) == 0
    for one, other in ((known, "b"), (known_tube, "d")):
        for path in one.iterdir():
            assert path.read_bytes() == (tmp_path / other / path.name).read_bytes()
    assert main([*start, *mu, "--set", "tube=0.3", *rest, str(tmp_path / "e")]) == 2
    assert "tube is given as --tube and by --set; give it once" in capsys.readouterr().err


# --- AUTO itself ---


@pytest.mark.outside
@pytest.mark.parametrize(
    ("name", "word"),
    [
        ("spinning by phi_dot", "flutter"),
        ("spinning by mu", "flutter"),
        ("tumbling by theta", "flutter"),
        ("oscillator", "flutter"),
    ],
)
def test_autos_hopf_points_are_the_boundaries(name: str, word: str, tmp_path: Path) -> None:
    folder = os.environ.get("AUTO_DIR", "/usr/lib/auto-07p")
    library = Path(folder) / "lib"
    needed("gfortran", "gfortran")
    if not (library / "equilibrium.o").exists():
        pytest.skip("no AUTO-07p on this machine (Debian: auto-07p).")
    make, given = CASES[name]
    family = make()
    st.auto_input(family, tmp_path, name="problem", **given)
    include = next(
        p.parent
        for p in (Path(folder) / "include", Path(folder).parents[1] / "include")
        for p in [p / "auto_f2c.h"]
        if p.exists()
    )
    objects = [str(o) for o in sorted(library.glob("*.o"))]
    for command in (
        ["gcc", "-O2", "-w", f"-I{include}", "-c", "problem.c"],
        [
            "gfortran",
            "-O2",
            "-fopenmp",
            "problem.o",
            *objects,
            f"-L{library}",
            "-lauto_c",
            "-o",
            "problem",
        ],
    ):
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True)
    shutil.copy(tmp_path / "c.problem", tmp_path / "fort.2")
    subprocess.run(["./problem"], cwd=tmp_path, check=True, capture_output=True, timeout=60)
    rows = [line.split() for line in (tmp_path / "fort.7").read_text().splitlines()]
    hopf = [float(r[4]) for r in rows if len(r) > 6 and r[0] == "1" and r[2] == "3"]
    low, high = sorted((given["start"], given["stop"]))
    own = {n: v for n, v in given.items() if n not in ("free", "start", "stop")}
    at = {n: own.pop(n) for n in family.at if n in own}
    asked: dict[str, Any] = own | ({"at": next(iter(at.values()))} if at else {})
    points = st.boundaries(family, axis=(given["free"], low, high, 20), **asked)
    edges = [p.value for p in points if p.crossing.word == word]
    assert edges and sorted(hopf) == pytest.approx(sorted(edges), rel=2e-5, abs=1e-7)
