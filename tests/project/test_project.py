"""The project keeps its word: cheap import, layers, versions, documentation."""

import ast
import re
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path

import pytest

import stability
from stability.base.lazy import HOMES
from stability.base.version import DISTRIBUTION

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "stability"
FROM_FIGURES_UP = (
    "figures",
    "atlas",
    "cli",
    "compare/figures.py",
    "compare/report.py",
    "compare/plan.py",
)
"""Where matplotlib, tqdm and argparse may be imported."""
WITH_SYMPY = (
    "algebra/number_types.py",
    "derivation",
    "export/to_latex.py",  # its printer
    "tables",
    "compare",
    "systems/sources/sympy_models.py",  # reads the user's SymPy models, imports SymPy when called
)
"""Where SymPy may be imported."""


def test_importing_the_package_loads_nothing_heavy() -> None:
    code = "import sys, stability; print(sorted({m.split('.')[0] for m in sys.modules}))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(ast.literal_eval(out.stdout))
    heavy = {"casadi", "numpy", "scipy", "sympy", "xarray", "matplotlib", "flint", "pandas"}
    assert not loaded & heavy


FIRST_CALLS = {
    "st.spectrum('rolling', at=1.2, contact=st.Viscous(0.3))": {"scipy", "xarray"},
    "st.boundaries('rolling', axis=('at', 0.1, 2, 9), contact=st.Viscous(0.3))": {
        "scipy",
        "xarray",
    },
    "st.stability_map('rolling', x=('at', 1, 2, 8), y=('mu', 0.1, 2, 6))": set(),
    "st.simulate(st.Disk(), st.Viscous(0.3), {'theta': 1.5, 'omega3': 1.8}, 5.0)": {"scipy"},
    "st.basins(st.Disk(), st.Viscous(0.3), x=('at', 1, 2, 2), y=('tilt', 0.1, 0.5, 2), "
    "family='rolling', horizon=5.0)": {"scipy"},
    "main('simulate --theta 1.5 --omega3 1.8 --mu 0.3 --time 5'.split())": {"scipy"},
}
"""Calls in a fresh process, and libraries that each does without; none needs those of `IDLE`."""
IDLE = {"sympy", "numba", "dask", "matplotlib", "h5py"}
"""Libraries whose import takes longer than the rest of such a call."""


@pytest.mark.few(2)
@pytest.mark.parametrize("call", FIRST_CALLS)
def test_a_first_call_imports_only_what_it_needs(call: str) -> None:
    code = f"import sys, stability as st; from stability.cli.commands import main; {call}"
    code += "; print(sorted({m.split('.')[0] for m in sys.modules}))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(ast.literal_eval(out.stdout.splitlines()[-1]))
    assert not loaded & (IDLE | FIRST_CALLS[call])


def test_every_public_name_loads_and_is_documented() -> None:
    for name in HOMES:
        value = getattr(stability, name)
        if callable(value):
            assert value.__doc__
    with pytest.raises(AttributeError):
        stability.nothing  # noqa: B018


@pytest.mark.long
def test_the_function_spectrum_is_not_hidden_by_a_module() -> None:
    code = "import stability.spectra.spectrum, stability as st; print(callable(st.spectrum))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout == "True\n"


@cache
def _texts() -> dict[Path, str]:
    return {path: path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}


def _imports(path: Path) -> set[str]:
    """First words of the modules that a file imports, wherever it does."""
    return set(re.findall(r"^\s*(?:import|from)\s+(\w+)", _texts()[path], re.MULTILINE))


def _within(path: Path, places: tuple[str, ...]) -> bool:
    name = path.relative_to(PACKAGE).as_posix()
    return any(name == place or name.startswith(f"{place}/") for place in places)


def test_figures_progress_bars_and_sympy_stay_in_their_rooms() -> None:
    for path in PACKAGE.rglob("*.py"):
        found = _imports(path)
        if not _within(path, FROM_FIGURES_UP):
            assert not found & {"matplotlib", "tqdm", "argparse"}, path
        if not _within(path, WITH_SYMPY):
            assert "sympy" not in found, path


def test_no_folder_hides_a_public_name() -> None:
    folders = {p.parent.name for p in PACKAGE.glob("*/__init__.py")}
    assert not folders & set(HOMES)


NOT_OF_A_FOLDER = {"data", "docs", "faults", "oracles", "project", "release", "tools"}
"""Folders of tests that no folder of the package is named like."""


def test_tests_lie_in_folders_named_like_those_of_the_package() -> None:
    rooms = {p.name for p in PACKAGE.iterdir() if (p / "__init__.py").is_file()}
    folders = {p.name for p in (ROOT / "tests").iterdir() if p.is_dir()} - {"__pycache__"}
    assert folders == rooms | NOT_OF_A_FOLDER


def test_every_test_that_a_text_names_is_there() -> None:
    named = 0
    texts = [
        *PACKAGE.rglob("*.py"),
        *(ROOT / "tests").rglob("*.py"),
        *(ROOT / "docs").rglob("*.md"),
    ]
    for path in [*texts, ROOT / "README.md"]:
        for name in re.findall(
            r"(?<![\w/])(?:tests|benchmarks|notebooks|docs)/[\w/]+\.(?:py|cpp|json|md)\b",
            path.read_text(),
        ):
            assert (ROOT / name).is_file(), (path, name)
            named += 1
    assert named > 80


def test_the_version_stands_in_one_place() -> None:
    whole = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert whole["project"]["dynamic"] == ["version"]
    read = {"version": {"attr": "stability.base.version.__version__"}}
    assert whole["tool"]["setuptools"]["dynamic"] == read
    for name in ("pyproject.toml", "CITATION.cff", "conda-recipe/meta.yaml", "CONTRIBUTING.md"):
        assert stability.__version__ not in (ROOT / name).read_text(), name
    released = re.findall(r"^## (\d\S*)", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert stability.__version__ == released[0]


def test_every_dependency_is_pinned_for_those_who_come_later() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    names = [*project["dependencies"], *extras["test"], *extras["heyoka"], *extras["video"]]
    pinned = {
        line.split("==")[0].lower() for line in (ROOT / "constraints.txt").read_text().split()
    }
    for entry in names:
        if not entry.startswith(f"{project['name']}["):
            assert re.split(r"[<>=\[]", entry)[0].lower() in pinned


FOREIGN = re.compile(r"pip install ['\"]?stability(?!-nonholonomic)|[`'\" ]stability\[")
"""An installation of the package that has the name `stability` on the index, which is not ours."""


def test_no_line_installs_the_package_of_somebody_else() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["name"] == DISTRIBUTION
    assert project["scripts"] == {"stability": "stability.__main__:run"}
    texts = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *PACKAGE.rglob("*.py")]
    texts += [ROOT / "pyproject.toml", ROOT / "Makefile", *(ROOT / ".github").rglob("*.*")]
    wrong = [
        f"{path.relative_to(ROOT)}: {line}"
        for path in texts
        if path.name != "CHANGELOG.md"
        for line in path.read_text(encoding="utf-8").splitlines()
        if FOREIGN.search(line)
    ]
    assert not wrong


@pytest.mark.long
def test_public_functions_say_parameters_and_source_in_their_docstrings() -> None:
    """Each parameter of a public function is named in its docstring."""
    missing = []
    for path, source in _texts().items():
        if "Parameters\n" not in source:
            continue
        for node in ast.walk(ast.parse(source)):
            if not isinstance(node, ast.FunctionDef) or node.name.startswith("_"):
                continue
            text = ast.get_docstring(node) or ""
            arguments = [a.arg for a in (*node.args.args, *node.args.kwonlyargs)]
            arguments = [a for a in arguments if a not in ("self", "cls")]
            if len(arguments) > 1 and "Parameters" in text:
                missing += [f"{path.name}:{node.name}:{a}" for a in arguments if a not in text]
    assert not missing


def test_no_long_decimal_is_typed_into_the_package() -> None:
    for path, source in _texts().items():
        if not re.search(r"\d\.\d{11,}", source):
            continue
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Constant) and isinstance(node.value, float):
                assert not re.search(r"\d\.\d{11,}", repr(node.value)), path.name


@pytest.mark.long
def test_the_word_list_finds_its_words() -> None:
    sys.path.insert(0, str(PACKAGE.parent / "docs"))
    try:
        import words
    finally:
        sys.path.pop(0)
    text = "plain\nderived a" + "new, and wh" + "atever\nanewly"
    assert words.found(text) == [(2, "a" + "new"), (2, "wh" + "atever")]
    assert words.main() == 0


def test_hooks_of_a_commit_are_the_programs_of_lint() -> None:
    import yaml

    make = (ROOT / "Makefile").read_text().replace("$(BIN)", ".venv/bin")
    recipe = make.partition("\nlint:")[2].partition("\n\n")[0].splitlines()[1:]
    [local] = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"]
    hooks = [h["entry"].replace(" --force-exclude", "") for h in local["hooks"]]
    assert [line.strip().removesuffix(" .") for line in recipe] == hooks
