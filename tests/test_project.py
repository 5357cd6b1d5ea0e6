"""The project keeps its word: cheap import, layers, versions, documentation."""

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import stability

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "stability"
CORE = (
    "errors", "disk", "contact", "algebra", "tracked", "system", "equations", "graph", "families",
    "steadiness", "jordan", "exact_fields", "function_field", "multiplicity", "routh", "root_balls",
    "continuation", "steady", "enclosure", "polynomial", "verdict", "reduction", "modes", "spectra",
    "problem", "query", "grid", "files", "boundary", "curves", "cells", "maps", "exact", "certify",
    "kernels", "factoring", "growth", "tiles", "boxes", "stream", "derivation", "hurwitz",
    "decomposition", "formulas", "slowflow", "passage", "lines", "flow", "route", "taylor",
    "stepping", "sundials", "integrators", "rest", "sticking", "outcome", "settling", "attraction",
    "painleve", "launches", "crossings", "changes", "critical", "ratios", "roots", "search",
    "shadow", "branches", "settings", "motion", "trajectory", "records",
)  # fmt: skip


def test_importing_the_package_loads_nothing_heavy() -> None:
    code = "import sys, stability; print(sorted({m.split('.')[0] for m in sys.modules}))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(ast.literal_eval(out.stdout))
    heavy = {"casadi", "numpy", "scipy", "sympy", "xarray", "matplotlib", "flint", "pandas"}
    assert not loaded & heavy


def test_every_public_name_loads_and_is_documented() -> None:
    for name in stability.__all__:
        value = getattr(stability, name)
        assert name in dir(stability)
        if callable(value):
            assert value.__doc__
    with pytest.raises(AttributeError):
        stability.nothing  # noqa: B018


def test_the_function_spectrum_is_not_hidden_by_a_module() -> None:
    code = (
        "import stability.maps, stability.boundary, stability as st; print(callable(st.spectrum))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout == "True\n"


def test_the_core_knows_no_plotting_no_command_line_and_no_progress_bar() -> None:
    for name in CORE:
        tree = ast.parse((PACKAGE / f"{name}.py").read_text())
        modules = {
            (node.module or "") if isinstance(node, ast.ImportFrom) else alias.name
            for node in ast.walk(tree)
            if isinstance(node, (ast.Import, ast.ImportFrom))
            for alias in node.names
        }
        assert not {
            m for m in modules if re.match(r"(matplotlib|tqdm|argparse|plots|loci|cli|atlas)", m)
        }


def test_what_is_compared_knows_no_plotting() -> None:
    shown = ("drawings", "strips", "squares", "workings", "report")
    for path in (PACKAGE / "compare").glob("*.py"):
        if path.stem not in shown:
            assert not re.search(r"matplotlib|tqdm|argparse", path.read_text()), path.name


def test_spectra_know_no_disk() -> None:
    for name in (
        "spectra",
        "reduction",
        "modes",
        "families",
        "graph",
        "polynomial",
        "enclosure",
        "system",
    ):
        text = (PACKAGE / f"{name}.py").read_text()
        imports = re.findall(r"^\s*from \.(\w+) import (.+)$", text, re.MULTILINE)
        assert not {m for m, what in imports if m in ("equations", "steady", "contact")}
        assert not [what for m, what in imports if m == "disk" and "Disk" in what]


def test_versions_agree() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["version"] == stability.__version__
    assert f"## {stability.__version__}" in (ROOT / "CHANGELOG.md").read_text()


def test_every_dependency_is_pinned_for_those_who_come_later() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    names = [*project["dependencies"], *extras["test"], *extras["heyoka"], *extras["video"]]
    pinned = {
        line.split("==")[0].lower() for line in (ROOT / "constraints.txt").read_text().split()
    }
    for entry in names:
        if not entry.startswith("stability["):
            assert re.split(r"[<>=\[]", entry)[0].lower() in pinned


def test_public_functions_say_parameters_and_source_in_their_docstrings() -> None:
    """Each parameter of a public function is named in its docstring."""
    missing = []
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.FunctionDef) or node.name.startswith("_"):
                continue
            text = ast.get_docstring(node) or ""
            arguments = [a.arg for a in (*node.args.args, *node.args.kwonlyargs)]
            arguments = [a for a in arguments if a not in ("self", "cls")]
            if len(arguments) > 1 and "Parameters" in text:
                missing += [f"{path.name}:{node.name}:{a}" for a in arguments if a not in text]
    assert not missing


def test_no_long_decimal_is_typed_into_the_package() -> None:
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Constant) and isinstance(node.value, float):
                assert not re.search(r"\d\.\d{11,}", repr(node.value)), path.name
