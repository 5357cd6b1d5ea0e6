"""Every block of code on the site is run by its build, or says why it is not."""

from __future__ import annotations

import ast
import re
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
MADE_BY_THE_BUILD = ("_made", "notebooks", "sphinx_parts", "films")
PAGES = sorted(
    p for p in DOCS.rglob("*.md") if p.relative_to(DOCS).parts[0] not in MADE_BY_THE_BUILD
)
OUTPUT = "text"
"""Language of what a program prints."""
NOT_CODE = ("{toctree}", "{literalinclude}", "{live}", "{made}", OUTPUT)
RUN = ("{code-cell}", "{run}", "{file}", "{checkout}", "{edit}", "sh", "python")


def part(name: str) -> Any:
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        return import_module(f"sphinx_parts.{name}")
    finally:
        sys.path.pop(0)


def fences(text: str) -> list[tuple[str, str]]:
    """Language and content of each block."""
    found = re.findall(r"^(```+)(\S*)[^\n]*\n(.*?)^\1$", text, re.DOTALL | re.MULTILINE)
    return [(language, body) for _, language, body in found]


def test_every_name_that_a_block_imports_from_the_package_is_there() -> None:
    found = [
        (page, statement.module, alias.name)
        for page in PAGES
        for language, body in fences(page.read_text(encoding="utf-8"))
        if language in ("{code-cell}", "python")
        for statement in ast.walk(ast.parse(re.sub(r"^[:%].*$", "", body, flags=re.MULTILINE)))
        if isinstance(statement, ast.ImportFrom)
        and (statement.module or "").startswith("stability")
        for alias in statement.names
    ]
    assert len(found) > 10
    for page, module, name in found:
        where = import_module(module)
        assert hasattr(where, name), f"{page.name}: {module} has no {name}"


def test_every_block_of_every_page_is_run_by_the_build_or_says_why_not() -> None:
    assert len(PAGES) > 30
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for language, _ in fences(text):
            assert language in (*RUN, *NOT_CODE), (page, language)
            assert language != "python" or text.startswith("#")  # `notebooks.executed` takes it
        commands_are_run_or_say_why_not(page, text)
        lines_that_it_edits_are_there(page, text)


def commands_are_run_or_say_why_not(page: Path, text: str) -> None:
    shell = part("blocks")
    blocks = shell.BLOCK.findall(text)
    assert len(blocks) == sum(language == "sh" for language, _ in fences(text))
    assert text.count("<!-- run with") + text.count("<!-- not run:") == sum(
        bool(kind) for kind, *_ in blocks
    )  # each stands just above a block
    for kind, words, body in blocks:
        if kind == "run with ":
            assert shell.changed(body, words) != body, page
        elif kind:
            assert len(words) > 10, page


def test_words_that_are_not_in_the_commands_are_refused() -> None:
    shell = part("blocks")
    assert shell.changed("a 100", "100 -> 2") == "a 2"
    with pytest.raises(ValueError, match="200"):
        shell.changed("a 100", "200 -> 2")


def lines_that_it_edits_are_there(page: Path, text: str) -> None:
    for name, after in re.findall(r"^```\{edit\} (\S+)\n:after: '(.*)'$", text, re.MULTILINE):
        known = (ROOT / name).read_text(encoding="utf-8") if (ROOT / name).is_file() else text
        assert after in known, (page, name, after)


def test_a_file_that_a_page_adds_is_not_one_of_the_package() -> None:
    for page in PAGES:
        for name in re.findall(r"^```\{file\} (\S+)", page.read_text("utf-8"), re.MULTILINE):
            assert not (ROOT / name).exists(), (page, name)


def test_a_table_that_a_page_adds_has_a_name_of_its_own() -> None:
    from stability.tables.registry import PLACES

    page = (DOCS / "howto" / "table.md").read_text(encoding="utf-8")
    [name] = re.findall(r'^    "(\w+)": "\w+",$', page, re.MULTILINE)
    assert name not in PLACES
