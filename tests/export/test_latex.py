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
from stability.derivation.latex import symbol, symbols

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


def read(lines: list[tuple[str, str]], names: dict[str, float]) -> dict[str, float]:
    """Values of all lines in order; a line may use those before it."""
    found = dict(names)
    for left, right in lines:
        if left:
            found[left] = value(right, found)
    return found


def part(whole: str, title: str) -> list[tuple[str, str]]:
    """Lines of the sections from a title to the next other one."""
    return displays(whole.split(title, 1)[1].split(r"\section*{", 1)[0])


@pytest.mark.parametrize("name", SYSTEMS)
def test_equations_and_jacobian_read_back_as_the_graph(name: str) -> None:
    """An independent reader of the text, against CasADi's evaluation and its differences."""
    system = SYSTEMS[name]()
    words = text(name, "system")
    assert balanced(words)
    x, p = RNG.uniform(0.5, 1.2, len(system.states)), RNG.uniform(0.5, 1.2, len(system.parameters))
    shown = symbols((*system.states, *system.parameters))
    names = dict(zip(shown.values(), [*x, *p], strict=True))
    found = read([*part(words, "Equations of motion"), *part(words, r"\section*{Jacobian}")], names)
    graph = ca.Function("f", [system.x, system.p], [system.rhs, ca.jacobian(system.rhs, system.x)])
    rates, slopes = (np.asarray(v) for v in graph(x, p))

    def rate(symbol: str) -> str:
        return (
            symbol.replace(r"\dot", r"\ddot", 1)
            if symbol.startswith(r"\dot")
            else rf"\dot{{{symbol}}}"
        )

    for i, state in enumerate(system.states):
        assert found[rate(shown[state])] == pytest.approx(rates[i, 0], rel=1e-11, abs=1e-12), state
        for j, other in enumerate(system.states):
            left = rf"\frac{{\partial {rate(shown[state])}}}{{\partial {shown[other]}}}"
            assert found.get(left, 0.0) == pytest.approx(slopes[i, j], rel=1e-10, abs=1e-11)


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
    names |= {
        r"\sin\left(\theta\right)": np.sin(plain["theta"]),
        r"\cos\left(\theta\right)": np.cos(plain["theta"]),
    }
    lines = part(words, "Characteristic polynomial")
    coefficients = {
        left: value(right, names) for left, right in lines if re.fullmatch(r"p_\{\d+,\d+\}", left)
    }
    roots: list[complex] = []
    head = re.search(r"\\\[(.*?) = 0 \\\]", words.split("Characteristic polynomial")[1])
    assert head
    for number, many in re.findall(r"p_\{(\d+)\}\(\\lambda\)(?:\^\{(\d+)\})?", head[1]):
        terms = {
            int(k[3:-1].split(",")[1]): v
            for k, v in coefficients.items()
            if k[3:-1].split(",")[0] == number
        }
        row = [terms.get(n, 0.0) for n in range(max(terms), -1, -1)]
        roots += list(np.roots(row)) * int(many or 1)
    zero = re.search(r"\\lambda(?:\^\{(\d+)\})? p_", head[1])
    roots += [0.0] * (int(zero[1] or 1) if zero else 0)
    system = family.system
    jacobian = ca.Function("J", [system.x, system.p], [ca.jacobian(system.rhs, system.x)])
    values = [own.get(n, plain.get(n)) for n in system.parameters]
    wanted = np.linalg.eigvals(np.asarray(jacobian(state, values)))
    assert len(roots) == len(wanted)
    for root in roots:
        near = wanted[np.argmin(abs(wanted - root))]
        assert abs(near - root) < 2e-6 * max(1, abs(root)), (root, wanted)


def test_conditions_that_are_printed_change_sign_at_the_boundary() -> None:
    """Spinning of a rough torus: one polynomial, zero at the boundary of the package."""
    family = st.Torus(0.2).family("spinning", "rough")
    [edge] = st.boundaries(family, axis=("phi_dot", 0.1, 3, 9), tube=0.3)
    lines = part(text("torus", "family"), "Conditions of stability")
    signs = []
    for shift in (-1e-6, 1e-6):
        names = {symbol("phi_dot"): edge.value + shift, symbol("tube"): 0.3}
        found = []
        for _, right in lines:
            left, sign, _ = re.split(r" ([<>=]) ", right)
            found.append(value(left, names) * (1 if sign == ">" else -1))
        signs.append(min(found))
    assert signs[0] < 0 < signs[1]


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
    """With amsmath and geometry alone, as texlive-latex-base has them."""
    needed("texlive-latex-base", "pdflatex")
    bicycle = str(Path(__file__).parents[2] / "examples" / "bicycle.py:upright")
    assert (
        main(["export", "latex", "--system", bicycle, "--out", str(tmp_path / "bicycle.tex")]) == 0
    )
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
