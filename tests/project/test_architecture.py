"""The page on the architecture and its picture agree with the code of today."""

import ast
import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from stability.base.lazy import HOMES

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "stability"
PAGE = ROOT / "docs" / "explanation" / "architecture.md"
CHANGES = (
    "a contact law",
    "a body",
    "a source of systems",
    "a family",
    "a quantity with a unit",
    "what *settled* means",
    "an integrator",
    "a question of a scene",
    "a production route to a verdict",
    "a method to compare with",
    "a figure",
    "how a verdict is drawn: hatching, sign, colour of boxes and marks",
    "a table",
    "a column of a table",
    "an option of a command",
    "a command",
    "a hard case",
    "a format of datasets",
    "an output format of figures or tables",
    "an eigenvalue backend",
)
QUESTIONS = ("spectrum", "boundaries", "stability_map", "simulate")
FOLDERS = sorted(p.parent.name for p in PACKAGE.glob("*/__init__.py"))
ROOMS = sorted(p.parent for p in PACKAGE.glob("*/**/__init__.py"))


def _script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("house", ROOT / "docs" / "house.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules["house"] = module  # dataclasses look there for the names in annotations
    spec.loader.exec_module(module)
    return module


house = _script()


@pytest.fixture(scope="module")
def today() -> Any:
    return house.house()


def links(text: str) -> list[tuple[str, Path]]:
    """Text and target of every link that stays in the repository."""
    found = re.findall(r"\[([^\]]*)\]\(([^)]+)\)", text)
    return [(words, PAGE.parent / target) for words, target in found if "://" not in target]


def named(text: str) -> list[Path]:
    """Files and folders that are named in code style, within the root or the package."""
    words = re.findall(r"`([\w./-]+)`", text)
    paths = [w for w in words if "/" in w and not w.startswith(".venv")]
    return [PACKAGE / w if (PACKAGE / w).exists() else ROOT / w for w in paths]


def blocks() -> list[str]:
    """Rows of tables, and items of numbered lists: each names files and what is in them."""
    lines = PAGE.read_text().split("\n")
    found: list[str] = []
    for line in lines:
        if re.match(r"\d\. |\| ", line):
            found.append(line)
        elif line.startswith("   ") and found:
            found[-1] += " " + line.strip()
    return found


# --- the picture ---


def test_the_picture_is_the_one_of_todays_imports(today: Any) -> None:
    assert house.recorded() == house.record(today), (
        "run .venv/bin/python docs/house.py and commit docs/house.svg"
    )


@pytest.mark.long
def test_the_picture_can_be_drawn(tmp_path: Path, today: Any) -> None:
    house.main(tmp_path / "house.svg")
    assert house.recorded(tmp_path / "house.svg") == house.record(today)


def test_arrows_say_all_imports_and_none_twice(today: Any) -> None:
    arrows: dict[str, list[str]] = {name: [] for name in FOLDERS}
    for a, b in today.arrows:
        arrows[a].append(b)
    for name in FOLDERS:
        assert house.below(arrows, name) == house.below(today.needs, name)
    for a, b in today.arrows:
        assert b not in set().union(*(house.below(arrows, o) for o in arrows[a]))


def test_folders_of_a_floor_do_not_cover_each_other(today: Any) -> None:
    for row in house.placed(today):
        places = sorted((x, item) for item, x in row.items() if len(item) == 1)
        assert all(b[0] - a[0] > house.BOX[0] for a, b in zip(places, places[1:], strict=False))
        assert all(house.BOX[0] / 2 <= x <= house.WIDTH - house.BOX[0] / 2 for x, _ in places)


def _package(folder: Path, low: str) -> tuple[Path, Path]:
    """A package of two floors, whose lower folder holds a given line."""
    for name, text in {"low": low, "high": ""}.items():
        (folder / "stability" / name).mkdir(parents=True)
        (folder / "stability" / name / "__init__.py").write_text(f'"""{name.title()}.  More."""\n')
        (folder / "stability" / name / "one.py").write_text(text)
    contract = folder / "contract"
    contract.write_text("[importlinter:contract:floors]\nlayers =\n    high\n    low\n")
    return folder / "stability", contract


@pytest.mark.parametrize(
    "line",
    [
        "from ..high import one",
        "from ..high.one import x",
        "from .. import high",
        "import stability.high.one",
        "from stability import high",
        "def f():\n    from ..high.one import x",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from ..high import one",
    ],
)
def test_an_import_that_goes_up_is_seen_wherever_it_is(line: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"do not go down: \[\('low', 'high'\)\]"):
        house.house(*_package(tmp_path, line))


def test_a_folder_without_a_floor_is_refused(tmp_path: Path) -> None:
    package, contract = _package(tmp_path, "import os.high")
    assert house.house(package, contract).says == {"low": "Low", "high": "High"}
    contract.write_text(contract.read_text().replace("    low\n", ""))
    with pytest.raises(ValueError, match=r"no floor, or no folder: \['low'\]"):
        house.house(package, contract)


# --- the page ---


def test_every_folder_file_and_link_of_the_page_exists() -> None:
    text = PAGE.read_text()
    assert len(links(text)) > 50
    for words, path in links(text):
        assert path.exists(), words
    for path in named(text):
        assert path.exists(), path


def test_every_folder_is_named_and_linked() -> None:
    text = PAGE.read_text()
    for name in FOLDERS:
        assert f"[{name}](../../stability/{name}/__init__.py)" in text


def test_links_to_tests_name_tests_that_exist() -> None:
    examples = [(words, path) for words, path in links(PAGE.read_text()) if "tests" in path.parts]
    assert len(examples) >= len(CHANGES)
    for words, path in examples:
        assert f"def {words}(" in path.read_text(), words


def test_every_change_has_its_room_and_an_example() -> None:
    rows = [
        b.split(" | ") for b in blocks() if b.startswith(("| a ", "| an ", "| what ", "| how "))
    ]
    assert [row[0].removeprefix("| ") for row in rows] == list(CHANGES)
    for row in rows:
        assert len(row) == 4
        assert "tests/" in row[3]


def test_every_way_has_at_most_five_files() -> None:
    ways = re.findall(r"### `(\w+)\(.*?\n\n(.*?)\n\n", PAGE.read_text(), re.DOTALL)
    assert [name for name, _ in ways] == list(QUESTIONS)
    for name, way in ways:
        assert 1 < len(re.findall(r"^\d\. ", way, re.MULTILINE)) <= 5
        assert f"`{name}`" in way.split("\n")[0]


def test_names_on_the_page_are_in_the_files_next_to_them() -> None:
    """What a row or an item puts in code style is a public name, or in a file that it names."""
    for block in blocks():
        paths = [p for _, p in links(block)] + named(block)
        text = "\n".join(p.read_text() for p in paths if p.suffix == ".py")
        for name in re.findall(r"`(\w+)`", block):
            known = name in (*HOMES, *FOLDERS) or re.search(rf"\b{name}\b", text)
            assert known, f"{name}: {block}"


# --- the folders' own words ---


@pytest.mark.parametrize("folder", ROOMS, ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_a_folder_says_what_it_holds_and_how_to_add_to_it(folder: Path) -> None:
    text = ast.get_docstring(ast.parse((folder / "__init__.py").read_text()))
    assert text and "To add " in text
    lines = [line for line in text.split("\n") if line]
    assert 3 <= len(lines) <= 8
    assert max(map(len, lines)) <= 100
    for name in re.findall(r"`([\w./]+\.(?:py|md|json))`", text):
        assert any((place / name).exists() for place in (folder, PACKAGE, ROOT)), name


@pytest.mark.parametrize("name", FOLDERS)
def test_a_folder_says_what_it_may_import(name: str) -> None:
    floors = house.stated(ROOT / ".importlinter")
    level = {n: i for i, floor in enumerate(floors) for n in floor}
    text = ast.get_docstring(ast.parse((PACKAGE / name / "__init__.py").read_text())) or ""
    found = re.search(r"May import (.*?)(?:\.$|\.\s)", text, re.DOTALL | re.MULTILINE)
    assert found
    said = set(re.findall(r"`(\w+)`", found[1])) & set(FOLDERS)
    if "the floors below" in found[1]:
        lowest = max(level[n] for n in said)
        said |= {n for n in FOLDERS if level[n] > lowest}
    assert said == {n for n in FOLDERS if level[n] > level[name]}


def test_the_first_sentence_of_a_folder_fits_its_room_in_the_picture(today: Any) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    with house.style():
        figure = house.draw(today)
        renderer = FigureCanvasAgg(figure).get_renderer()
        for text in figure.axes[0].texts:
            if text.get_text() in today.says.values():
                width = text.get_window_extent(renderer).width / figure.dpi
                assert width < house.BOX[0] - 2 * house.MARGIN, text.get_text()
