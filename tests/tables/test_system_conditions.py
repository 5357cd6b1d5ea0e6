"""Exact conditions of a user's family as text, LaTeX and JSON, through the command line."""

import json
import re
import subprocess
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from pathlib import Path

import casadi as ca
import pytest
import sympy
from matplotlib.mathtext import MathTextParser
from programs import needed

import stability as st
from stability.cli.commands import main
from stability.derivation.latex import escaped, symbol
from stability.tables.system_conditions import latex, lines, record

BICYCLE = "examples/bicycle.py:upright"


@cache
def family() -> st.Family:
    """A quartic with an angle as a parameter, a root and an awkward name."""
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 3)
    a, b, angle = ca.vertsplit(p)
    rates = ca.vertcat(
        x[2],
        x[3],
        -(a**2) * x[0] - ca.sqrt(b) * x[2] + ca.sin(angle) * x[1],
        -b * x[1] - ca.cos(angle) ** 2 * x[3] - ca.sin(angle) * x[0],
    )
    system = st.System(
        "two_springs & 50%",
        x,
        p,
        rates,
        states=("q", "s", "u", "v"),
        parameters=("omega_0", "mu", "theta"),
    )
    return st.Family(system, "rest", at=("omega_0",), held=dict.fromkeys(system.states, 0.0))


# --- a strict reader of the LaTeX that is written ---


def check_latex(text: str) -> int:
    """Refuse unbalanced groups, environments, mathematics; each formula is parsed; their number."""
    plain = "\n".join(line for line in text.splitlines() if not line.startswith("%"))
    assert plain.isascii()
    depth = 0
    for brace in re.findall(r"(?<!\\)[{}]", plain):
        depth += 1 if brace == "{" else -1
        assert depth >= 0
    assert depth == 0
    stack: list[str] = []
    for word, name in re.findall(r"\\(begin|end)\{(\w+)\}", plain):
        if word == "begin":
            stack.append(name)
        else:
            assert stack.pop() == name
    assert not stack
    assert plain.count(r"\left(") == plain.count(r"\right)")
    displays = re.findall(r"\\\[(.*?)\\\]", plain, re.DOTALL)
    assert len(displays) == plain.count(r"\[") == plain.count(r"\]")
    outside = re.sub(r"\\\[.*?\\\]", "", plain, flags=re.DOTALL)
    assert len(re.findall(r"(?<!\\)\$", outside)) % 2 == 0
    inline = re.findall(r"(?<!\\)\$(.*?)(?<!\\)\$", outside)
    words = re.sub(r"(?<!\\)\$.*?(?<!\\)\$", "", outside)
    body = re.sub(r"\\begin\{tabular\}.*?\\end\{tabular\}", "", words, flags=re.DOTALL)
    assert not re.search(r"(?<!\\)[_^&#%]", body), body
    formulas = list(inline)
    for display in displays:
        assert display.count(r"\begin{aligned}") == display.count(r"\end{aligned}") == 1
        inner = re.sub(r"\\(begin|end)\{aligned\}|\\tag\{C\d+\}", "", display)
        for row in inner.split("\\\\\n"):
            assert row.count("&") == 1
            assert len(row) < 200
            formulas.append(row.replace("&", " "))
    for formula in formulas:
        parsed(formula.strip())
    return len(formulas)


@cache
def parsed(formula: str) -> object:
    """A formula read by matplotlib's reader of TeX."""
    return MathTextParser("path").parse(f"${formula}$")


def test_the_reader_of_latex_refuses_what_is_wrong() -> None:
    good = latex(st.conditions(family()))
    check_latex(good)
    for bad in (
        good.replace("}", "", 1),
        good.replace(r"\end{aligned}", "", 1),
        good + "$",
        good + " a_1",
        good.replace("&", "", 30),
        good.replace(r"\right)", "", 1),
        good.replace(r"\sqrt{", r"\sqroot{"),
    ):
        assert bad != good
        with pytest.raises((AssertionError, ValueError, IndexError)):
            check_latex(bad)


def test_latex_is_well_formed_and_defines_each_symbol() -> None:
    found = st.conditions(family(), positive=("mu",))
    text = latex(found)
    assert check_latex(text) > 5
    for v in found.variables:
        assert f"${symbol(v.name)}$ & " in text
    assert r"\toprule" in text
    assert r"\omega_{0}" in text
    assert r"\sqrt{\mu}" in text
    assert r"two\_springs \& 50\%" in text


def compile_latex(text: str, folder: Path) -> None:
    """Compile with the TeX that is there."""
    head = r"\documentclass{article}\usepackage{amsmath,booktabs}\begin{document}"
    (folder / "paper.tex").write_text(f"{head}\n{text}\n\\end{{document}}\n")
    program = needed("texlive-latex-recommended", "pdflatex", "tectonic", "xelatex")
    options = [] if program == "tectonic" else ["-interaction=nonstopmode", "-halt-on-error"]
    subprocess.run([program, *options, "paper.tex"], cwd=folder, check=True, capture_output=True)
    assert (folder / "paper.pdf").stat().st_size > 1000
    if program == "pdflatex":
        assert re.findall("Overfull .*", (folder / "paper.log").read_text(errors="replace")) == []


@pytest.mark.outside
def test_latex_compiles(tmp_path: Path) -> None:
    compile_latex(latex(st.conditions(family(), positive=("mu",))), tmp_path)


def printed(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(["table", "conditions", *words]) == 0
    return capsys.readouterr().out


def test_the_command_prints_text_latex_and_json(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("--system", BICYCLE, "--positive", "v,g")
    text = printed(capsys, *words)
    assert text.startswith("bicycle, upright")
    assert "flutter boundary" in text
    assert "self-stable" not in text  # what the example prints itself
    assert "disk" not in text
    assert "≈: coefficients" in text
    assert check_latex(printed(capsys, *words, "--latex")) > 5
    body = json.loads(printed(capsys, *words, "--json"))
    assert [b["kind"] for b in body["boundaries"]] == ["static", "flutter"]
    v, g = sympy.symbols("v g")
    (static,) = (c for c in body["conditions"] if c["kind"] == "static")
    zero = sympy.sympify(static["positive"])
    assert zero.free_symbols == {v, g}
    capsize = max(map(float, sympy.Poly(zero.subs(g, sympy.Rational(981, 100)), v).nroots()))
    assert abs(capsize - 6.024262015) < 1e-8  # Meijaard et al. 2007, § 5
    fixed = json.loads(printed(capsys, *words[:3], "v", "--set", "g=9.81", "--json"))
    assert fixed["given"] == {"g": "981/100"}  # a text is exact
    assert "decimals=True" in fixed["numbers"]
    short = json.loads(printed(capsys, *words, "--decimals", "--json"))
    assert "80.81722 = 4040861/50000" in short["numbers"]
    assert [x["name"] for x in fixed["variables"]] == ["v"]


def test_text_says_roundings_proofs_and_witnesses() -> None:
    found = st.conditions(family(), positive=("mu", "omega_0"))
    text = "\n".join(lines(found))
    assert "sin(theta)" in text
    assert "≈" not in text  # short coefficients are exact
    assert "Stable where C1 > 0 and C2 > 0; unstable where one of these is negative." in text
    for i, c in enumerate(found.deciding, start=1):
        assert f"C{i} decides: {c.kind:<9} {c.polynomial} > 0" in text
        assert f"{c.polynomial} > 0" in found.rule
    body = record(found)
    assert {"system", "rule", "conditions", "relations"} <= set(body)
    assert json.loads(json.dumps(body)) == body


def test_print_says_what_was_given_and_assumed_with_units() -> None:
    """As one would paste it: numbers with units, assumptions, labels in place of long formulas."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 4)
    v, trail, k, c = ca.vertsplit(p)
    rates = ca.vertcat(
        x[1], -k * x[0] - (c + 0.3) * x[1] + 9.81 * v * x[2], -x[2] * trail * (v + k) - c * x[0] * v
    )
    system = st.System(
        "towed",
        x,
        p,
        rates,
        states=("y", "u", "a"),
        parameters=("v", "trail", "k", "c"),
        units={"v": "m/s", "trail": "m", "k": "1/s^2"},
    )
    family = st.Family(system, "straight", at=("v",), held=dict.fromkeys(system.states, 0.0))
    exact = Fraction("0.07")
    found = st.conditions(family, positive=("v", "c"), trail=exact, k=0.3)
    text = "\n".join(lines(found))
    assert "given: trail = 0.07 m, k ≈ 0.3 1/s²" in text
    assert "assumed: v > 0, c > 0" in text
    assert "m/s, c = " in text  # a witness, without the numbers that are given
    assert "C1 decides" in text
    assert "9007199254740992" not in text.split("λ^3")[1].split("Numbers such as")[0]
    formula = latex(found)
    check_latex(formula)
    for part in (
        r"\mathit{trail} = 0.07$ m",
        r"$k \approx 0.3$ 1/s$^{2}$",
        "Assumed: $v > 0$, $c > 0$",
        r"\tag{C1}",
        "Stable where C1 $>$ 0",
        "nearest doubles",
    ):
        assert part in formula
    body = record(found)
    assert body["units"] == {"v": "m/s", "trail": "m", "k": "1/s^2"}
    assert body["given"] == {"trail": "7/100", "k": str(Fraction(0.3))}


@pytest.mark.parametrize(
    "place",
    [
        "lagrange_top.py:sleeping",
        *(
            pytest.param(f"{name}.py:{family}", marks=pytest.mark.long)
            for name, family in (
                ("bicycle", "upright"),
                ("watt_governor", "running"),
                ("triangular_points", "triangle"),
                ("railway_wheelset", "centred"),
            )
        ),
    ],
)
def test_latex_of_the_examples_is_well_formed(
    place: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = printed(capsys, "--system", f"examples/{place}", "--latex", "--decimals")
    assert check_latex(text) > 2
    assert "disk" not in text


@pytest.mark.outside
def test_latex_of_an_example_compiles(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = ("--system", "examples/watt_governor.py:running", "--latex", "--decimals")
    compile_latex(printed(capsys, *words), tmp_path)


@pytest.mark.few(6)
@pytest.mark.parametrize(
    ("words", "part"),
    [
        (("families", "--system", BICYCLE), "a family (--system) belongs"),
        (("conditions", "--system", "examples/bicycle.py"), "module:family"),
        (("conditions", "--system", "examples/bicycle.py:nobody"), "its families are upright"),
        (("conditions", "--system", "examples/nothing.py:upright"), "cannot be imported"),
        (("conditions", "--system", "no_module_here:upright"), "cannot be imported"),
        (("conditions", "--system", BICYCLE, "--k", "0.25"), "belongs to the disk"),
        (("conditions", "--system", BICYCLE, "--latex", "--json"), "both given"),
        (("conditions", "--system", BICYCLE, "--positive", "w"), "positive is 'w'"),
        (("conditions", "--system", BICYCLE, "--set", "g"), "NAME=NUMBER"),
        (("conditions", "--system", BICYCLE, "--set", "h=1"), "--set names 'h'"),
        (("conditions", "--system", BICYCLE, "--set", "family=1"), "--set names 'family'"),
        (("conditions", "--system", BICYCLE, "--set", "g=1/0"), "g is '1/0'"),
        (("conditions", "--decimals"), "family of your own (--system)"),
        (("conditions", "--positive", "v"), "family of your own (--system)"),
    ],
)
def test_bad_input_ends_with_one_sentence_and_code_2(
    words: tuple[str, ...], part: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["table", *words]) == 2
    said = capsys.readouterr().err
    assert part in said
    assert said.count("\n") == 1


def test_a_symbol_is_safe_for_any_name() -> None:
    for name in (
        "v",
        "phi_dot",
        "x_1_2",
        "k1",
        "mass",
        "sin(2*theta + a_1)",
        "sqrt(b**2 - 1)",
        "sqrt_3",
        "Lambda",
        "_x",
        "exp(-t)",
        "breite_α",
    ):
        text = symbol(name)
        assert text.isascii()
        parsed(text)
    assert escaped("é_1") == r"é\_1"  # LaTeX reads UTF-8


def whirled(beyond: Callable[..., ca.SX]) -> st.Conditions:
    """λ² + c λ + (a² - b)² + beyond: stable where the constant term is positive."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    a, b, c = ca.vertsplit(p)
    stiffness = (a**2 - b) ** 2 + beyond(b, c)
    system = st.System(
        "whirled",
        x,
        p,
        ca.vertcat(x[1], -stiffness * x[0] - c * x[1]),
        states=("q", "v"),
        parameters=("a", "b", "c"),
    )
    rest = st.Family(system, "rest", at=("a",), held={"q": 0, "v": 0})
    return st.conditions(rest, positive=("c",))


def test_a_condition_that_is_a_sum_of_squares_is_proved_and_decides_nothing() -> None:
    found = whirled(lambda _, c: c**2)
    assert found.rule == "Stable at every member of the domain."
    assert not any("decides" in line for line in lines(found))


def test_a_condition_whose_sign_is_open_is_marked_so_in_rule_text_and_latex() -> None:
    # (a² - b)² + (b - c)² + c is positive; the proof would need shares of b²
    found = whirled(lambda b, c: (b - c) ** 2 + c)
    [condition] = found.deciding
    assert condition.status == "open"
    said = f"It is open whether {condition.polynomial} > 0 everywhere."
    assert found.rule.endswith(f"unstable where it is negative. {said}")
    assert any("It is open whether" in line for line in lines(found))
    assert "It is open whether C1 $>$ 0 everywhere." in latex(found)
