"""Every table in every form: CSV is read back by pandas, LaTeX compiles without overfull lines."""

import copy
import inspect
import io
import json
import pickle
import re
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import casadi as ca
import pandas as pd
import pytest
from programs import needed

import stability as st
from stability.bodies.families import FAMILIES
from stability.bodies.round_body.shapes.named import NAMED
from stability.cli.commands import _parser, main
from stability.tables.families import condition
from stability.tables.letters import mathematics, prose
from stability.tables.registry import PLACES, definition

SI = st.Disk(mass=0.00567, radius=0.01213, gravity=9.80665)
SPEED = (9.80665 * 0.01213) ** 0.5
OPTIONS: dict[str, dict[str, Any]] = {
    "families": {},
    "conditions": {"k": (0.25, 1 / 3), "mu": (0.3, 3.0)},
    "conditions in SI": {"k": 1 / 3, "mu": (3e-5, 3.123456e4), "disk": SI},
    "drift": {},
    "drift in SI": {"k": 1 / 3, "mu": (3e-4, 1e5), "disk": SI, "tilt": 0.0123456},
    "hopf": {"k": (0.375, 0.5), "mu": 0.9},
    "hopf in SI": {"k": 0.375, "mu": 0.9 / SPEED, "disk": SI},
    "thresholds": {},
    "peers": {},
    "toys": {},
    "list": {},
    "painleve": {"body": st.Torus(0.2)},
    "codimension": {"family": "spinning", "x": ("at", 0.5, 5, 9), "y": ("mu", 0.1, 3, 9)},
}
"""Options of a small table, by name; a second word says what is special."""


@cache
def made(case: str) -> st.Table:
    if case == "benchmarks":  # two systems
        systems = ["tippe top", "railway wheelset"]
        return listed("benchmarks", definition("benchmarks").rows(systems=systems))
    if case in ("own conditions", "own flutter"):
        return own(case)
    return st.table(case.split()[0], **OPTIONS.get(case, {}))


def listed(name: str, rows: list[dict[str, Any]]) -> st.Table:
    chosen = definition(name)
    return st.Table(
        name, chosen.heading, chosen.columns, rows, definition=chosen, citation=chosen.cites
    )


def own(case: str) -> st.Table:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    damping, load = p[0], p[1]
    rates = ca.vertcat(x[1], -x[0] - (damping - load) * x[1] - x[0] ** 2 * x[1])
    system = st.System(
        "belt & mass",
        x,
        p,
        rates,
        states=("y", "u"),
        parameters=("d", "speed"),
        units={"d": "1/s", "speed": "1/s"},
    )
    family = st.Family(system, "at_rest", at=("speed",), held={"y": 0.0, "u": 0.0})
    if case == "own conditions":
        return st.table("conditions", family, positive=("d",))
    return st.table("hopf", family, x=("speed", 0.1, 1.0, 5), d=0.5)


EVERY = (*OPTIONS, "benchmarks", "own conditions", "own flutter")
SLOW = {"families", "conditions", "conditions in SI", "benchmarks", "peers"}
"""Tables that take a second or more."""
BY_COST = [pytest.param(c, marks=pytest.mark.long if c in SLOW else ()) for c in EVERY]


# --- CSV and JSON ---


@pytest.mark.parametrize("case", BY_COST)
def test_csv_is_read_back_by_pandas(case: str) -> None:
    """Each number comes back in all its digits, below a header that names its unit."""
    table = made(case)
    frame = pd.read_csv(io.StringIO(table.to_csv()))
    assert len(frame) == len(table.rows) > 0
    for column in table.columns:
        unit = table.units.get(column.name)
        values = [row[column.name] for row in table.rows]
        if any(isinstance(v, dict) for v in values):
            continue
        name = column.title or column.name
        found = frame[f"{name} [{unit}]" if unit else name]
        for value, read in zip(values, found, strict=True):
            if value is None or value in ("", [], ()):
                assert pd.isna(read)
            elif isinstance(value, (float, int)):
                assert read == pytest.approx(
                    value, rel=1e-15, abs=0
                )  # pandas may lose the last bit
    assert list(table.to_pandas().columns) == list(frame.columns)


def test_units_are_those_of_the_disk_and_of_each_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """Time in seconds of a coin is √(R/g) times the number without dimension."""
    plain, coin = (
        st.table("drift", k=0.25, mu=1.0),
        st.table("drift", k=0.25, mu=1 / SPEED, disk=SI),
    )
    assert (plain.units["time_slow"], coin.units["time_slow"]) == ("√(R/g)", "s")
    assert (plain.units["mu"], coin.units["mu"]) == ("1/√(gR)", "s/m")
    clock = (0.01213 / 9.80665) ** 0.5
    for a, b in zip(plain, coin, strict=True):
        assert b["time_slow"] == pytest.approx(a["time_slow"] * clock, rel=1e-9)
    # without the formulas of the table, which take seconds
    monkeypatch.setattr("stability.derivation.formulas.rows", lambda *_: [])
    frame = st.table("conditions", **OPTIONS["conditions in SI"]).to_pandas()
    at = frame[frame["at"].notna()]
    assert set(at[at.family == "tumbling"].at_unit) <= {"rad"}
    assert set(at[at.family == "rolling"].at_unit) == {"rad/s"}


@pytest.mark.parametrize("case", BY_COST)
def test_json_says_what_each_column_holds(case: str) -> None:
    body = json.loads(made(case).to_json())
    for column, said in zip(made(case).columns, body["columns"], strict=True):
        assert said["name"] == column.name
        assert len(said["meaning"]) > 5
    assert all(set(row) <= {c["name"] for c in body["columns"]} for row in body["rows"])


@pytest.mark.parametrize("case", BY_COST)
def test_a_table_pickles_and_prints(case: str) -> None:
    table = made(case)
    again = pickle.loads(pickle.dumps(table))
    assert again == table == copy.deepcopy(table)
    assert hash(again) == hash(table)
    assert str(again) == table.to_text()
    assert again.to_latex() == table.to_latex()
    assert table._repr_html_().count("<tr") == len(table) + 1


# --- LaTeX ---


PACKAGES = "lmodern,amsmath,array,booktabs,longtable"


def pages(text: str, folder: Path) -> str:
    """The log of pdflatex: lines of 345 pt with a long table, else columns of 85 mm."""
    needed("texlive-latex-recommended, lmodern", "pdflatex")
    long = r"\begin{longtable}" in text
    kind, page = ("", "") if long else ("[twocolumn]", r"\usepackage[margin=18mm]{geometry}")
    head = rf"\documentclass{kind}{{article}}{page}\usepackage{{{PACKAGES}}}\begin{{document}}"
    (folder / "paper.tex").write_text(f"{head}\n{text}\n\\end{{document}}\n")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "paper.tex"]
    for _ in range(2):
        done = subprocess.run(command, cwd=folder, capture_output=True)
        assert done.returncode == 0, done.stdout[-2000:]
    return (folder / "paper.log").read_text(errors="replace")


@pytest.mark.outside
@pytest.mark.parametrize("case", EVERY)
def test_latex_compiles_without_overfull_lines(case: str, tmp_path: Path) -> None:
    log = pages(made(case).to_latex(), tmp_path)
    assert re.findall(r"(Overfull .*|Undefined .*|LaTeX Warning: Ref.*)", log) == []


@pytest.mark.outside
def test_long_units_of_a_users_system_leave_no_overfull_line(tmp_path: Path) -> None:
    x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    rates = ca.vertcat(x[1], -ca.sin(x[0]) + c * (x[1] - x[1] ** 3))
    system = st.System(
        "swing",
        x,
        c,
        rates,
        states=("q", "v"),
        parameters=("c",),
        units={"q": "rad", "v": "rad/s", "c": "N*m^2*s"},
    )
    family = st.Family(system, "rest", at=("c",), held={"q": 0, "v": 0})
    for text in (
        st.table("hopf", family, x=("c", -1, 1, 9)).to_latex(),
        st.table("conditions", family).to_latex(),
    ):
        assert r"[N$\cdot$m$^{2}$$\cdot$s]" in text
        assert re.findall(r"(Overfull .*|Undefined .*)", pages(text, tmp_path)) == []


@pytest.mark.outside
def test_the_log_shows_a_line_that_is_too_long(tmp_path: Path) -> None:
    text = made("drift").to_latex().replace("Spectrally", "Spectrally" * 20)
    assert "Overfull" in pages(text, tmp_path)


@pytest.mark.parametrize("case", BY_COST)
def test_every_table_has_rules_and_defines_its_symbols(case: str) -> None:
    text = made(case).to_latex()
    for rule in (r"\toprule", r"\midrule", r"\bottomrule"):
        assert rule in text
    defined = re.sub(r"\\begin\{(longtable|tabular\*)\}.*?\\end\{\1\}", "", text, flags=re.DOTALL)
    for column in made(case).columns:
        if column.latex:
            assert f"${column.latex}$: " in defined
    text.encode("latin-1")  # pdflatex knows no other letters


def test_numbers_in_latex_are_those_of_the_rows() -> None:
    table = made("drift in SI")
    body = re.split(r"\\endfoot|\\midrule", table.to_latex())[-1].split(r"\end{")[0]
    lines = [line for line in body.splitlines() if "&" in line]
    assert len(lines) == len(table)
    for line, row in zip(lines, table, strict=True):
        cells = [c.strip(" $\\") for c in line.removesuffix(r"\\").split("&")]
        read = [float(re.sub(r"\\cdot10\^\{(-?\d+)\}", r"e\1", c)) for c in cells]
        assert read == pytest.approx(list(row.values()), rel=1e-3)


@pytest.mark.parametrize(
    ("plain", "typeset"),
    [
        ("2*k*z - 1 > 0", "2k\\,z-1>0"),
        ("sqrt(x_1) <= (a + b)**2", r"\sqrt{x_{1}}\le (a+b)^{2}"),
        ("φ̇² ≠ ω₃", r"\dot\varphi^{2}\ne \omega _{3}"),
        ("mu*² < 1e-12", r"\mu_{*}^{2}<1\cdot10^{-12}"),
    ],
)
def test_formulas_are_typeset(plain: str, typeset: str) -> None:
    assert mathematics(plain) == typeset


def test_sentences_keep_their_words() -> None:
    assert prose("a root of a_1 at J. P. LaSalle's 5 m/s") == (
        "a root of $a_{1}$ at J. P. LaSalle's 5 m/s"
    )


def test_points_have_names_units_and_bounds_that_one_reads() -> None:
    head = made("codimension").to_csv().splitlines()[0].split(",")
    assert head[1:5] == [
        "phi_dot [√(g/R)]",
        "phi_dot error [√(g/R)]",
        "mu [1/√(gR)]",
        "mu error [1/√(gR)]",
    ]
    text = made("codimension").to_latex()
    assert r"kind & $\dot\varphi$ & $\pm$ & $\mu$ & $\pm$" in text
    powers = [int(p) for p in re.findall(r"10\^\{(-\d+)\}", text)]
    assert powers and min(powers) >= -17


@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
@pytest.mark.long
def test_points_take_the_coefficient_that_codimension_two_takes() -> None:
    axes = {"x": ("at", 1.9, 2.1, 2), "y": ("c", 0.9, 1.1, 2)}
    linear = st.table("codimension", "spinning", contact="linear-viscous", **axes)
    assert linear.units["y"] == "m √(g/R)"


def test_points_of_a_body_have_its_units() -> None:
    torus = st.Torus(0.2).family("spinning", "viscous")
    axes = {"x": ("phi_dot", 1, 3, 2), "y": ("mu", 0.5, 1.5, 2)}
    of_body = st.table("codimension", torus, **axes, tube=0.2)
    assert of_body.to_csv().startswith("kind,phi_dot [√(g/R)],")


# --- the command and the function agree ---


def test_the_command_takes_the_arguments_of_the_function() -> None:
    parameters = inspect.signature(st.table).parameters
    named = {n for n, p in parameters.items() if p.kind is not p.VAR_KEYWORD} - {"progress"}
    [commands] = [a for a in _parser()._actions if a.choices]
    options = {a.dest for a in commands.choices["table"]._actions}
    forms = {"help", "json", "csv", "latex", "out", "force", "list"}
    bodies = {
        n
        for make in NAMED.values()
        for n, p in inspect.signature(make).parameters.items()
        if p.kind is not p.VAR_KEYWORD
    } | {"length"}
    scales = {"mass", "radius", "gravity"}
    assert options - forms - {"system", "set"} - scales - bodies == named - {"disk"}


@pytest.mark.parametrize("name", PLACES)
def test_options_of_a_definition_are_arguments(name: str) -> None:
    assert set(definition(name).takes) <= set(inspect.signature(st.table).parameters)


def test_the_command_prints_what_the_function_returns(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    words = ["table", "drift", "--k", "0.25", "--mu", "0.3,3"]
    words += ["--mass", "2", "--radius", "1", "--gravity", "1"]
    table = st.table(
        "drift", k=0.25, mu=(0.3, 3.0), disk=st.Disk(mass=2.0, radius=1.0, gravity=1.0)
    )
    for form, text in (
        ("csv", table.to_csv()),
        ("latex", table.to_latex()),
        ("json", table.to_json()),
    ):
        assert main([*words, f"--{form}"]) == 0
        assert capsys.readouterr().out.rstrip() == text.rstrip()
    for ending, text in (
        (".csv", table.to_csv()),
        (".tex", table.to_latex()),
        (".json", table.to_json()),
        (".txt", table.to_text()),
    ):
        file = tmp_path / f"drift{ending}"
        assert main([*words, "--out", str(file)]) == 0
        assert file.read_text("utf-8").rstrip() == text.rstrip()
        assert capsys.readouterr().out.strip() == str(file)
    assert main([*words, "--out", str(tmp_path / "drift.csv")]) == 2
    assert "exists" in capsys.readouterr().err
    assert main([*words, "--out", str(tmp_path / "drift.csv"), "--overwrite"]) == 0


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (("drift", "--csv", "--json"), "--json and --csv are both given"),
        (("drift", "--csv", "--out", "a.csv"), "--csv and --out are both given"),
        (
            ("drift", "--out", "drift.xlsx"),
            "--out is 'drift.xlsx'; the name must end in .csv, .json, .tex or .txt.",
        ),
        (("drift", "--x", "at:1:2:3"), "x belongs to"),
        (("thresholds", "--k", "0.25"), "k belongs to `table conditions`"),
        (("theorems",), "table theorems is proved and printed by theorems_disk now"),
        (("bodies", "--json"), "by theorems_steady and theorems_stability now"),
        (("completeness",), "by theorems_steady now, in the notebooks"),
    ],
)
def test_bad_options_end_with_one_sentence(
    words: tuple[str, ...], part: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["table", *words]) == 2
    said = capsys.readouterr().err
    assert part in said
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("name", "given", "part"),
    [
        ("lift", {}, "table is 'lift'; known are families"),
        ("families", {"k": 0.25}, "`table conditions`, `drift`, `hopf` and `codimension` only"),
        ("drift", {"speed": 3.0}, "'speed' is not an argument of the table drift"),
        ("conditions", {"family": "rolling"}, "a family by name belongs to `table codimension`"),
        ("codimension", {"family": "rolling"}, "takes x and y"),
        ("launches", {}, "table is 'launches'; known are families, conditions, drift"),
        ("circular", {}, "known are families, conditions, drift, hopf, painleve, benchmarks"),
    ],
)
def test_the_function_says_what_is_wrong(name: str, given: dict[str, Any], part: str) -> None:
    with pytest.raises(st.StabilityError, match=re.escape(part)):
        st.table(name, **given)


@pytest.mark.parametrize("name", ["rolling", "spinning"])
def test_a_family_that_exists_everywhere_has_no_condition(name: str) -> None:
    assert condition(name) == f"none: every {FAMILIES[name].at[0]}"


def test_a_file_of_another_ending_is_refused(tmp_path: Path) -> None:
    with pytest.raises(st.StabilityError, match=r"must end in \.csv, \.json, \.tex or \.txt\."):
        made("drift").write(tmp_path / "drift.docx")
