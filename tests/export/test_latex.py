"""LaTeX of systems and families: it closes, it compiles, and it reads back as the same numbers."""

import re
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from latex_reader import balanced, displays, value
from programs import needed

import stability as st
from stability.cli.commands import main
from stability.derivation.latex import dotted, symbol, symbols

RNG = np.random.default_rng(7)


def pump() -> st.System:
    """Every function that a formula may have, with awkward names."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    rates = ca.vertcat(
        x[1] / (1 + ca.exp(-x[0])) - p[0] ** 3 * ca.tanh(x[2]),
        -ca.sqrt(1 + x[0] ** 2) * ca.atan(x[1]) + 1e-7 * x[2] - (x[0] - (x[1] - x[2])),
        -((x[0] + p[1]) ** 2) * ca.log(2 + x[2]) ** 2 / (x[1] * (3 - x[0])) ** 2 - -p[1] * 1.5,
    )
    return st.System(
        "pump & 100% rod",
        x,
        p,
        rates,
        states=("q1", "q_1", "theta_dot"),
        parameters=("damping_rate", "Omega"),
    )


SYSTEMS: dict[str, Any] = {
    "pump": pump,
    "double pendulum": lambda: double_pendulum(),
    "viscous disk": lambda: st.disk_system("viscous"),
    "rough disk": lambda: st.disk_system("rough"),
    "torus": lambda: st.Torus(0.2).family("spinning", "viscous").system,
}
FAMILIES: dict[str, Any] = {
    "spinning disk": (lambda: st.disk_family("spinning", "viscous"), ("k", "mu")),
    "rough tumbling disk": (lambda: st.disk_family("tumbling", "rough"), ("k",)),
    "torus": (lambda: st.Torus(0.2).family("spinning", "rough"), ("tube",)),
}


@cache
def text(name: str, kind: str) -> str:
    if kind == "system":
        return st.latex(SYSTEMS[name]())
    make, positive = FAMILIES[name]
    return st.latex(make(), positive=positive)


def part(whole: str, title: str) -> list[tuple[str, str, str]]:
    """Equations from a title to the next."""
    return displays(whole.split(title, 1)[1].split(r"\section*{", 1)[0])


Lines = list[tuple[str, str, str]]


def defined(lines: Lines, names: dict[str, float]) -> tuple[dict[str, float], Lines]:
    """Names with the divisors and roots that lines define, and the other lines."""
    names = dict(names)
    rest = []
    for line in lines:
        if re.fullmatch(r"[DR]_\{\d+\}", line[0]):
            names[line[0]] = value(line[2], names)
        else:
            rest.append(line)
    return names, rest


def solved(lines: Lines, names: dict[str, float], unknowns: list[str]) -> list[float]:
    """The numbers of linear equations, whose slopes are differences."""
    rows, right = [], []
    for left, _, other in lines:

        def residual(values: list[float], left: str = left, other: str = other) -> float:
            table = names | dict(zip(unknowns, values, strict=True))
            return value(left, table) - value(other, table)

        rest = residual([0.0] * len(unknowns))
        units = np.eye(len(unknowns)).tolist()
        rows.append([residual(unit) - rest for unit in units])
        right.append(-rest)
    return list(np.linalg.solve(np.array(rows), np.array(right)))


def rate(symbol: str) -> str:
    return {r"\dot\theta": r"\ddot\theta", r"\dot\varphi": r"\ddot\varphi"}.get(
        symbol, dotted(symbol)
    )


@pytest.mark.parametrize("name", SYSTEMS)
def test_equations_and_slopes_read_back_as_the_graph(name: str) -> None:
    """An independent reader of the text, against CasADi's evaluation and its differences."""
    system = SYSTEMS[name]()
    words = text(name, "system")
    assert balanced(words)
    x, p = RNG.uniform(0.5, 1.2, len(system.states)), RNG.uniform(0.5, 1.2, len(system.parameters))
    shown = symbols((*system.states, *system.parameters))
    names = dict(zip(shown.values(), [*x, *p], strict=True))
    forces = [symbols([u])[u] for u in system.unknowns if u.removeprefix("d_") not in shown]
    names, lines = defined(part(words, "Equations of motion"), names)
    same = [s for s in system.states if s.removesuffix("_dot") in shown and s.endswith("_dot")]
    told = [rate(shown[s]) for s in system.states if f"{s}_dot" not in same]
    found = dict(zip([*told, *forces], solved(lines, names, [*told, *forces]), strict=True))
    graph = ca.Function("f", [system.x, system.p], [system.rhs, ca.jacobian(system.rhs, system.x)])
    rates, slopes = (np.asarray(v) for v in graph(x, p))
    for i, state in enumerate(system.states):
        if rate(shown[state]) in found:
            assert found[rate(shown[state])] == pytest.approx(rates[i, 0], rel=1e-10, abs=1e-11)

    names, lines = defined(part(words, "Linearised equations"), names | found)
    compare_slopes(lines, names | found, system, slopes)


def compare_slopes(lines: Lines, names: dict[str, float], system: Any, slopes: Any) -> None:
    """Rates of deviations that lines give, against the columns of a Jacobian."""
    shown = symbols((*system.states, *system.parameters))
    told = [rate(s) for n, s in shown.items() if n in system.states]
    told = [s for s in told if any(rf"\delta {s}" in left for left, _, _ in lines)]
    forces = [symbols([u])[u] for u in system.unknowns if u.removeprefix("d_") not in shown]
    moved = [rf"\delta {s}" for s in [*told, *forces]]
    for j, other in enumerate(system.states):
        deviations = {rf"\delta {shown[s]}": float(s == other) for s in system.states}
        answers = dict(zip(moved, solved(lines, names | deviations, moved), strict=True))
        for i, state in enumerate(system.states):
            if (left := rf"\delta {rate(shown[state])}") in answers:
                assert answers[left] == pytest.approx(slopes[i, j], rel=1e-9, abs=1e-10)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", FAMILIES)
def test_the_polynomial_that_is_printed_has_the_eigenvalues_of_the_family(name: str) -> None:
    """Coefficients read back, their roots against LAPACK's eigenvalues of the family's matrix."""
    make, _ = FAMILIES[name]
    family = make()
    words = text(name, "family")
    assert balanced(words)
    at = [0.8] if family.at == ("theta",) else [2.1]
    given = RNG.uniform(0.2, 0.45, len(family.parameters))
    state = family.member(at, given)
    own = dict(zip((*family.at, *family.parameters), (*at, *given), strict=True))
    plain = dict(zip(family.system.states, state, strict=True)) | own
    names = {symbol(n): float(v) for n, v in plain.items()}
    system = family.system
    jacobian = ca.Function("J", [system.x, system.p], [ca.jacobian(system.rhs, system.x)])
    values = [own.get(n, plain.get(n)) for n in system.parameters]
    slopes = np.asarray(jacobian(state, values))
    forces = {left: value(right, names) for left, _, right in part(words, "Steady motions")[1:]}
    known, lines = defined(part(words, "Linearised equations"), names | forces)
    compare_slopes(lines, known, system, slopes)

    head = re.search(r"\\\[(.*?) = 0 \\\]", words.split("Characteristic polynomial")[1])
    assert head
    lines = part(words, "Characteristic polynomial")
    ratios = []
    for lam in (0.3, 1.1, 2.9):
        table = names | {r"\lambda": lam}
        for left, _, right in reversed(lines):  # coefficients follow what they are of
            if left.startswith("p_"):
                table[left] = value(right, table)
        whole = np.linalg.det(lam * np.eye(len(slopes)) - slopes)
        ratios.append(value(head[1], table) / whole)
    assert ratios == pytest.approx([ratios[0]] * 3, rel=1e-8)


def test_conditions_that_are_printed_change_sign_at_the_boundary() -> None:
    """Spinning of a rough torus: one polynomial, zero at the boundary of the package."""
    family = st.Torus(0.2).family("spinning", "rough")
    [edge] = st.boundaries(family, axis=("phi_dot", 0.1, 3, 9), tube=0.3)
    lines = part(text("torus", "family"), "Conditions of stability")
    signs = []
    for shift in (-1e-6, 1e-6):
        names = {symbol("phi_dot"): edge.value + shift, symbol("tube"): 0.3}
        sides = [value(left, names) * (1 if sign == ">" else -1) for left, sign, _ in lines]
        signs.append(min(sides))
    assert signs[0] < 0 < signs[1]


def double_pendulum() -> st.System:
    q, u, p = (ca.vertcat(*map(ca.SX.sym, names.split())) for names in ("a b", "v w", "M m l g"))
    M, m, l, g = ca.vertsplit(p)  # noqa: N806, E741
    bend = m * l**2 * u[0] * u[1] * ca.cos(q[0] - q[1])
    kinetic = (M + m) * l**2 * u[0] ** 2 / 2 + m * l**2 * u[1] ** 2 / 2 + bend
    potential = -(M + m) * g * l * ca.cos(q[0]) - m * g * l * ca.cos(q[1])
    return st.mechanics(q, u, p, kinetic=kinetic, potential=potential, name="double pendulum")


def test_mechanics_keep_their_mass_matrix_and_names() -> None:
    """The textbook's equations of the double pendulum, a line each (Goldstein, ch. 1)."""
    words = st.latex(double_pendulum(), standalone=False).split(r"\section*{Lin")[0]
    lines = displays(words)
    bend = r"l^{2} \, m \, \cos{\left(a - b \right)}"
    assert [left for left, _, _ in lines] == [
        r"\dot{a}",
        r"\dot{b}",
        rf"l^{{2}} \, \left(M + m\right) \, \dot{{v}} + {bend} \, \dot{{w}}",
        rf"{bend} \, \dot{{v}} + l^{{2}} \, m \, \dot{{w}}",
    ]
    assert "w_{" not in words and "0.5" not in words


def test_a_condition_that_always_holds_is_not_printed() -> None:
    x, c, k = ca.SX.sym("x", 2), ca.SX.sym("c"), ca.SX.sym("k")
    rates = ca.vertcat(x[1], -k * x[0] - c * x[1])
    system = st.System("s", x, ca.vertcat(c, k), rates, states=("x", "v"), parameters=("c", "k"))
    rest = st.Family(system, "rest", at=("c",), held={"x": 0.0, "v": 0.0})
    words = st.latex(rest, positive=("c",), standalone=False).split("Conditions")[1]
    assert [line[0] for line in displays(words)] == ["k"]
    words = st.latex(rest, positive=("c", "k"), standalone=False).split("Conditions")[1]
    assert "1 > 0" not in words
    assert "Stable at every member" in words


def test_equations_that_nobody_can_read_are_refused() -> None:
    with pytest.raises(st.StabilityError, match="too many to print; stability.export.c_code"):
        st.latex(st.Egg().family("rolling", "viscous").system)


def test_conditions_alone_and_a_part_of_a_document() -> None:
    family = st.disk_family("spinning", "rough")
    found = st.conditions(family, positive=("k",))
    words = st.latex(found, standalone=False)
    assert "documentclass" not in words and "Equations of motion" not in words
    assert words in st.latex(family, positive=("k",), standalone=False)


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("mu", r"\mu"),
        ("x_10", "x_{10}"),
        ("omega_theta", r"\omega_{\theta}"),
        ("I3", "I_{3}"),
        ("speed", r"\mathit{speed}"),
        ("a_b_c", "a_{b,c}"),
        ("y_dot", r"\dot{y}"),
        ("sqrt(b)", r"\sqrt{b}"),
    ],
)
def test_names_become_symbols(name: str, shown: str) -> None:
    assert symbol(name) == shown


def test_what_has_no_formula_is_refused() -> None:
    numeric = st.System.from_function(lambda x, p: [-x[0]], name="fall", states=("x",))  # noqa: ARG005
    with pytest.raises(st.StabilityError, match="Python function"):
        st.latex(numeric)
    with pytest.raises(st.StabilityError, match="give a System, a Family or its name, or Cond"):
        st.latex(3)  # type: ignore[arg-type]


def test_a_number_that_is_not_finite_is_refused() -> None:
    x = ca.SX.sym("x")
    with pytest.raises(st.StabilityError, match="not finite"):
        st.latex(st.System("broken", x, ca.SX(0, 1), -x * ca.inf, states=("x",)))


def test_a_switch_and_an_angle_have_signs_that_are_read() -> None:
    x, v, d = (ca.SX.sym(n) for n in ("x", "v", "D_1"))
    rates = ca.vertcat(ca.fabs(x) * ca.atan2(v, x), ca.sign(v) / (1 + x**2 + v**2 + d) ** 2)
    system = st.System("switch", ca.vertcat(x, v), d, rates, states=("x", "v"), parameters=("D_1",))
    assert displays(st.latex(system, standalone=False).split(r"\section*{Lin")[0]) == [
        ("D_{2}", "=", "D_{1} + v^{2} + x^{2} + 1"),  # D_1 is the user's
        (r"\dot{x}", "=", r"\left|{x}\right| \, \operatorname{atan2}\left(v, x\right)"),
        (r"\dot{v}", "=", r"\frac{\operatorname{sign}\left(v\right)}{D_{2}^{2}}"),
    ]


def test_the_command_writes_a_document(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "spinning.tex"
    words = ["export", "latex", "spinning", "--contact", "rough", "--out", str(out)]
    assert main(words) == 0
    assert out.read_text() == st.latex(st.disk_family("spinning", "rough"), positive=("k",))
    assert main(words) == 2
    assert "exists" in capsys.readouterr().err
    assert main([*words[:-1], str(tmp_path / "a.pdf")]) == 2
    assert main([*words, "--overwrite", "--axis", "k:1:2"]) == 2
    assert "has no --axis" in capsys.readouterr().err


@pytest.mark.outside
def test_documents_compile_without_overfull_lines(tmp_path: Path) -> None:
    """In a column of 85 mm, with amsmath and geometry alone, as texlive-latex-base has them."""
    needed("texlive-latex-base", "pdflatex")
    bicycle = str(Path(__file__).parents[2] / "examples" / "bicycle.py:upright")
    assert (
        main(["export", "latex", "--system", bicycle, "--out", str(tmp_path / "bicycle.tex")]) == 0
    )
    (tmp_path / "pendulum.tex").write_text(st.latex(double_pendulum()))
    for name in SYSTEMS:
        (tmp_path / f"{name}.tex").write_text(text(name, "system"))
    for name in FAMILIES:
        (tmp_path / f"family {name}.tex").write_text(text(name, "family"))
    for file in sorted(tmp_path.glob("*.tex")):
        job = file.stem.replace(" ", "-")
        done = subprocess.run(
            [
                "pdflatex",
                "-draftmode",
                "-interaction=nonstopmode",
                "-halt-on-error",
                f"-jobname={job}",
                file.name,
            ],
            cwd=tmp_path,
            capture_output=True,
        )
        assert done.returncode == 0, done.stdout[-2000:]
        assert "Overfull" not in (tmp_path / f"{job}.log").read_text(errors="replace"), file
