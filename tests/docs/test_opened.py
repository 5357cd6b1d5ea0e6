"""The check of the site in a browser finds each kind of fault; `make docs-opened` runs it."""

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
SQUARE = (
    "data:image/svg+xml,<svg xmlns=%22http://www.w3.org/2000/svg%22 width=%2210%22 "
    "height=%2210%22/>"
)


@pytest.mark.browser
def test_each_fault_of_a_page_is_found(browser: Any, tmp_path: Path) -> None:
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        opened = import_module("sphinx_parts.opened")
    finally:
        sys.path.pop(0)
    pages = {
        "good": "<p>text</p>",
        "wide": '<p style="width: 700px">text</p>',  # of a phone only
        "loud": "<script>console.error('no')</script>",
        "broken": "<script>nothing()</script>",
        "greedy": '<img src="https://example.invalid/a.png">',
        "squashed": f'<img src="{SQUARE}" width="200" height="100">',
        "sharp": f'<img src="{SQUARE}" width="200" height="200">',
        "empty": '<iframe src="none.html"></iframe>',
    }
    head = '<!doctype html><link rel="icon" href="data:,">'
    head += '<meta name="viewport" content="width=device-width">'
    for name, body in pages.items():
        (tmp_path / f"{name}.html").write_text(head + body)
    (tmp_path / "none.html").write_text("")
    found = list(opened.faults(browser, tmp_path))
    looks = {(line.split(".html (")[0], line.split("(")[1].split(")")[0]) for line in found}
    assert looks == {
        *(
            (name, look)
            for name in ("loud", "broken", "greedy", "empty", "squashed")
            for look in opened.LOOKS
        ),
        ("wide", "phone"),
    }
