"""Words that a reader of English as a second language must look up: none in code or documents.

Run by `make lint`.  The message names a plain word for each.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
REPORT = ROOT / "docs" / "report"
"""An example of what `make report` writes, in the words of the version that wrote it."""
FOREIGN = (
    REPORT,
    ROOT / "stability" / "explorer" / "library",
    ROOT / "docs" / "_made",
    ROOT / "docs" / "notebooks",
)
"""Folders left out: that example, a library of others, and what the build of the site makes."""
FOLDERS = (
    "stability",
    "docs",
    "tests",
    "benchmarks",
    "examples",
    "notebooks",
    "paper",
    "conda-recipe",
    ".github",
)
"""Folders with pages, beyond the files next to the README."""
TEXTS = (".py", ".md", ".js", ".html", ".css", ".toml", ".yaml", ".cff")
"""Endings of files with sentences; the Makefile has none."""
PLAIN = {
    "told apart": "distinguished",
    "anew": "again",
    "dearer": "more expensive",
    "handed on": "passed on",
    "gone on with": "resumed",
    "so long as": "while",
    "anybody": "a user",
    "whatever": "any, for every",
    "goes with": "belongs to",
    "stands for": "means",
    "stand for": "mean",
    "way on": "continuation",
    "deaf": "ignores signals",
    "beside": "next to, near",
    "besides": "also, apart from",
    "in vain": "for nothing",
    "otherwise than": "in another way than",
    "hand on": "pass on",
    "hands on": "passes on",
    "hence": "so",
    "thus": "so",
    "upon": "on",
    "likewise": "the same",
    "whilst": "while",
    "amongst": "among",
    "thereby": "so, by this",
    "wherein": "in which",
    "whereby": "by which",
    "thereof": "of it",
    "herein": "in this",
    "albeit": "though",
    "lest": "so that not",
    "henceforth": "from now on",
    "hitherto": "so far",
    "nought": "zero",
}
"""What to write in place of each."""
WORD = re.compile(rf"\b({'|'.join(PLAIN)})\b", re.IGNORECASE)


def found(text: str) -> list[tuple[int, str]]:
    """Line numbers and words."""
    return [
        (number, match.group().lower())
        for number, line in enumerate(text.splitlines(), 1)
        for match in WORD.finditer(line)
    ]


def pages() -> list[Path]:
    """Every file that has sentences of this project: pages, code, scripts, settings."""
    found = [p for p in ROOT.iterdir() if p.suffix in TEXTS or p.name == "Makefile"]
    for folder in FOLDERS:
        found += [p for p in (ROOT / folder).rglob("*") if p.suffix in TEXTS]
    left_out = {Path(__file__).resolve(), *FOREIGN}
    return sorted(p for p in found if p.is_file() and left_out.isdisjoint((p, *p.parents)))


def main() -> int:
    """Print each place; 1 if there is one."""
    bad = 0
    for page in pages():
        for number, word in found(page.read_text(encoding="utf-8")):
            print(f"{page.relative_to(ROOT)}:{number}: {word}: write {PLAIN[word]}")
            bad = 1
    return bad


if __name__ == "__main__":
    sys.exit(main())
