"""The word list is applied to every file that has sentences of this project."""

import runpy
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
WORDS: dict[str, Any] = runpy.run_path(str(ROOT / "docs" / "words.py"))


@pytest.mark.few(3)
@pytest.mark.parametrize(
    "name",
    [
        "README.md",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "CODE_OF_CONDUCT.md",
        "Makefile",
        "CITATION.cff",
        "pyproject.toml",
        "conda-recipe/meta.yaml",
        "paper/paper.md",
        "paper/figures.py",
        ".github/PULL_REQUEST_TEMPLATE.md",
        ".github/ISSUE_TEMPLATE/bug.md",
        "stability/explorer/page.html",
        "stability/explorer/script/parts/point_panel.js",
        "examples/scenes/spun-coin.toml",
        "docs/explanation/explorer.md",
        "tests/project/test_words.py",
    ],
)
def test_a_file_with_sentences_is_read(name: str) -> None:
    assert ROOT / name in WORDS["pages"]()


def test_words_of_others_and_of_an_older_version_are_left() -> None:
    read = {p.relative_to(ROOT).as_posix() for p in WORDS["pages"]()}
    assert "docs/words.py" not in read
    assert not [p for p in read if p.startswith(("stability/explorer/library", "docs/report"))]


def test_every_word_of_the_list_is_found_with_its_line() -> None:
    assert WORDS["found"]("plain\nInXVain and " + "in" + " vain") == [(2, "in" + " vain")]
    for word in WORDS["PLAIN"]:
        assert WORDS["found"](f"a {word.title()}, b") == [(1, word)]


@pytest.mark.long
def test_no_file_has_a_word_of_the_list(capsys: pytest.CaptureFixture[str]) -> None:
    assert WORDS["main"]() == 0, capsys.readouterr().out
