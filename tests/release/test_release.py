"""Wheel, sdist, recipe and paper: built, installed elsewhere, and consistent."""

import re
import runpy
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest
import yaml

from stability.base.citation import WORKS
from stability.base.version import __version__
from stability.tables.benchmarks.catalogue import CASES

ROOT = Path(__file__).resolve().parents[2]
WHOLE: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())
PROJECT: dict[str, Any] = WHOLE["project"]
PACKAGE = ROOT / "stability"
OTHER_NAMES = {"matplotlib-base": "matplotlib", "heyoka.py": "heyoka"}
"""Names of a recipe that a wheel has otherwise."""


def command(*words: Any, cwd: Path, **environment: str) -> str:
    bare = {"PATH": "/usr/bin:/bin", "HOME": str(cwd)} | environment
    done = subprocess.run(
        [str(w) for w in words], cwd=cwd, capture_output=True, text=True, env=bare
    )
    assert done.returncode == 0, f"{words}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
    return done.stdout


def kept() -> dict[str, str]:
    """Settings of pip that a sandbox may need."""
    import os

    return {n: v for n, v in os.environ.items() if n.startswith(("PIP_", "SSL_"))}


# --- texts that must agree ---


def recipe() -> dict[str, Any]:
    text = (ROOT / "conda-recipe" / "meta.yaml").read_text()
    text = text.replace("{{ version }}", __version__).replace("{{ PYTHON }}", "python")
    return dict(
        yaml.safe_load("\n".join(ln for ln in text.splitlines() if not ln.startswith("{%")))
    )


def bounds(lines: list[str]) -> dict[str, str]:
    """Least version by name."""
    found = {}
    for line in lines:
        name, least = re.match(r"([\w.-]+)\s*>=\s*([\w.]+)", line).groups()  # type: ignore[union-attr]
        found[OTHER_NAMES.get(name, name)] = least
    return found


def test_the_recipe_asks_for_what_the_project_asks_for() -> None:
    asked = bounds(PROJECT["dependencies"]) | {"python": PROJECT["requires-python"][2:]}
    found = recipe()
    assert bounds(found["requirements"]["run"]) == asked
    extras = {}
    for group in PROJECT["optional-dependencies"].values():
        extras |= bounds([e.split(";")[0] for e in group if ">=" in e])
    for name, least in bounds(found["requirements"]["run_constrained"]).items():
        assert extras[name] == least
    [entry] = found["build"]["entry_points"]
    assert entry == f"stability = {PROJECT['scripts']['stability']}"
    assert found["package"]["version"] == __version__
    text = (ROOT / "conda-recipe" / "meta.yaml").read_text()
    [(file, pattern)] = re.findall(r'load_file="(.*?)", regex_pattern=\'(.*?)\'', text)
    read = re.search(pattern, (ROOT / "conda-recipe" / file).read_text())
    assert read and read.group(1) == __version__
    assert found["about"]["license"] == PROJECT["license"]
    assert found["about"]["summary"] == PROJECT["description"]
    host = {line.split()[0]: line.partition(">=")[2] for line in found["requirements"]["host"]}
    builds = bounds(WHOLE["build-system"]["requires"])
    assert host == {"python": asked["python"], "pip": "", **builds}


def test_the_recipe_says_what_to_replace_before_it_is_submitted() -> None:
    text = (ROOT / "conda-recipe" / "meta.yaml").read_text()
    assert recipe()["source"] == {"path": ".."}
    [note] = re.findall(r"^source:\n  # (.*)\n  path: \.\.$", text, re.MULTILINE)
    assert "url of the sdist" in note and "sha256" in note


def test_every_tool_of_a_release_is_pinned() -> None:
    pins = {
        line.split("==")[0].lower().replace("_", "-")
        for line in (ROOT / "constraints.txt").read_text().split()
    }
    for name in PROJECT["optional-dependencies"]["release"]:
        assert re.split(r"[>=\[]", name)[0] in pins


def test_templates_of_issues_have_a_name_and_a_purpose() -> None:
    found = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.md"))
    assert [p.stem for p in found] == ["bug", "feature", "wrong-verdict"]
    for path in found:
        head = yaml.safe_load(path.read_text().split("---")[1])
        assert {"name", "about"} <= set(head)


# --- the paper ---


def paper() -> str:
    return (ROOT / "paper" / "paper.md").read_text()


def test_the_paper_has_the_parts_that_a_journal_asks_for() -> None:
    head, body = paper().split("---\n", 2)[1:]
    given = yaml.safe_load(head)
    assert {"title", "tags", "authors", "affiliations", "date", "bibliography"} <= set(given)
    assert given["title"] == WORKS["stability"].title
    assert [a["name"] for a in given["authors"]] == [a["name"] for a in PROJECT["authors"]]
    parts = re.findall(r"^# (.*)$", body, re.MULTILINE)
    assert parts == [
        "Summary",
        "Statement of need",
        "State of the field",
        "Software design",
        "Research impact statement",
        "AI usage disclosure",
        "Acknowledgements",
        "References",
    ]
    assert 750 <= len(body.split()) <= 1750  # by the journal's page on its format


def test_every_work_of_the_paper_is_cited_and_known() -> None:
    entries = (ROOT / "paper" / "paper.bib").read_text()
    known = set(re.findall(r"^@\w+\{(\w+),", entries, re.MULTILINE))
    assert set(re.findall(r"@(\w+)", paper().split("---\n", 2)[2])) == known
    for key in known & set(WORKS):
        assert WORKS[key].bibtex in entries


def test_every_count_of_the_paper_is_one_that_its_script_prints() -> None:
    script = runpy.run_path(str(ROOT / "paper" / "figures.py"))
    assert script["REPORT"].is_file()
    rows = script["rows"]()
    assert [line for line in paper().splitlines() if re.match(r"\| .* \d", line)] == rows
    for name, marks in script["counts"]().items():
        if name in ("spectrum", "certified", "simulate"):
            assert marks["wrong"] == 0
    assert f"Of {len(CASES)} systems" in paper()
    assert (ROOT / "paper" / "spinning.png").read_bytes().startswith(b"\x89PNG")


# --- wheel and sdist ---

SHIPPED = {".py", ".json", ".pyi", ".html", ".typed", ".js", ".css", ".LICENSE"}
"""Endings of the files that a user needs: code, data, and the parts of pages."""


def tracked() -> set[str]:
    """Files of the package that are kept in the repository."""
    return set(command("git", "ls-files", "stability", cwd=ROOT).split())


def test_every_kind_of_file_of_the_package_is_shipped() -> None:
    """A file with a new ending must be named here, and by `package-data` of pyproject.toml."""
    assert {Path(name).suffix for name in tracked()} == SHIPPED
    data = WHOLE["tool"]["setuptools"]["package-data"]
    endings = {Path(pattern).suffix or f".{pattern.split('.')[1]}" for pattern in data["stability"]}
    assert endings == SHIPPED - {".py"}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder with the wheel and the sdist, of a copy of the tracked files."""
    folder = tmp_path_factory.mktemp("release")
    source, out = folder / "source", folder / "dist"
    source.mkdir()
    files = command("git", "ls-files", "-co", "--exclude-standard", cwd=ROOT).splitlines()
    for name in files:
        if (ROOT / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            (source / name).write_bytes((ROOT / name).read_bytes())
    command(sys.executable, "-m", "build", "-o", out, source, cwd=folder, **kept())
    return out


@pytest.mark.long
def test_wheel_and_sdist_have_every_module_and_all_data(built: Path) -> None:
    ours = {p.relative_to(ROOT).as_posix() for p in PACKAGE.rglob("*") if p.suffix in SHIPPED}
    assert SHIPPED == {Path(name).suffix for name in ours}
    assert "stability/py.typed" in ours
    [wheel], [sdist] = built.glob("*.whl"), built.glob("*.tar.gz")
    with zipfile.ZipFile(wheel) as inside:
        assert ours <= set(inside.namelist())
        text = next(n for n in inside.namelist() if n.endswith("METADATA"))
        metadata = inside.read(text).decode()
    assert f"\nVersion: {__version__}\n" in metadata
    with tarfile.open(sdist) as inside_:
        names = {n.partition("/")[2] for n in inside_.getnames()}
    assert ours | {"pyproject.toml", "LICENSE", "README.md"} <= names


@pytest.mark.long
@pytest.mark.parametrize("kind", ["*.whl", "*.tar.gz"])
def test_an_environment_of_its_own_runs_what_was_built(
    built: Path, kind: str, tmp_path: Path
) -> None:
    """Installed with pinned libraries, called far from the sources."""
    [file] = built.glob(kind)
    place = tmp_path / "environment"
    command(sys.executable, "-m", "venv", place, cwd=tmp_path)
    command(
        place / "bin" / "pip",
        "install",
        "-q",
        "-c",
        ROOT / "constraints.txt",
        file,
        cwd=tmp_path,
        **kept(),
    )
    stability = place / "bin" / "stability"
    assert command(stability, "--version", cwd=tmp_path).split()[-1] == __version__
    assert "usage: stability" in command(stability, "--help", cwd=tmp_path)
    said = command(
        stability, "spectrum", "rolling", "--at", "1.8", "--mu", "0.3", "--certify", cwd=tmp_path
    )
    assert "\nverdict     stable: " in said
    asked = ["spectrum", "spinning", "--body", "torus", "--tube", "0.2", "--at", "2", "--mu", "0.3"]
    assert "verdict" in command(stability, *asked, cwd=tmp_path)
    where = command(
        place / "bin" / "python", "-c", "import stability; print(stability.__file__)", cwd=tmp_path
    )
    assert Path(where.strip()).is_relative_to(place)
    pages = ["explore", "spinning", "--mu", "0.3", "--out"]
    command(stability, *pages, "page.html", cwd=tmp_path)
    command(
        sys.executable, "-m", "stability", *pages, "ours.html", cwd=tmp_path, PYTHONPATH=str(ROOT)
    )
    page = (tmp_path / "page.html").read_bytes()
    assert page.startswith(b"<!") and page == (tmp_path / "ours.html").read_bytes()
    film = tmp_path / "run.html"
    launch = ["--theta", "1.4", "--omega3", "1.5", "--mu", "0.3", "--time", "1"]
    command(stability, "simulate", *launch, "--film", film, cwd=tmp_path)
    assert film.stat().st_size > 10_000


@pytest.mark.long
def test_pipx_runs_the_command_line_from_the_wheel(built: Path, tmp_path: Path) -> None:
    [wheel] = built.glob("*.whl")
    said = command(
        sys.executable,
        "-m",
        "pipx",
        "run",
        "--pip-args",
        f"-c {ROOT / 'constraints.txt'}",
        "--spec",
        wheel,
        "stability",
        "spectrum",
        "rolling",
        "--at",
        "1.8",
        "--mu",
        "0.3",
        cwd=tmp_path,
        **kept(),
    )
    assert "\nverdict     stable: " in said
