"""The check of the site's own links finds each kind of broken link."""

import sys
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_a_link_to_no_file_or_no_place_is_found(tmp_path: Path) -> None:
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        broken = import_module("sphinx_parts.links").broken
    finally:
        sys.path.pop(0)
    (tmp_path / "a.html").write_text(
        '<p id="here"></p><a href="#here"></a><a href="b.html?x=1#there"></a>'
        '<a href="b.html#nowhere"></a><img src="none.png"><a href="https://example.org"></a>'
    )
    (tmp_path / "b.html").write_text('<p id="there"></p>')
    assert broken(tmp_path) == ["a.html: b.html#nowhere", "a.html: none.png"]
