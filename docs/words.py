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
PLAIN = {
    "told apart": "distinguished", "anew": "again", "dearer": "more expensive",
    "handed on": "passed on", "gone on with": "resumed", "so long as": "while",
    "anybody": "a user", "whatever": "any, for every", "goes with": "belongs to",
    "stands for": "means", "stand for": "mean", "way on": "continuation",
    "deaf": "ignores signals", "beside": "next to, near",
}  # fmt: skip
"""What to write in place of each."""
WORD = re.compile(rf"\b({'|'.join(PLAIN)})\b", re.IGNORECASE)


def found(text: str) -> list[tuple[int, str]]:
    """Line numbers and words."""
    return [
        (number, match.group().lower())
        for number, line in enumerate(text.splitlines(), 1)
        for match in WORD.finditer(line)
    ]


def main() -> int:
    """Print each place; 1 if there is one."""
    pages = [ROOT / "README.md", ROOT / "CHANGELOG.md"]
    for folder in ("stability", "docs", "tests", "benchmarks", "examples", "notebooks"):
        pages += [p for p in (ROOT / folder).rglob("*") if p.suffix in (".py", ".md")]
    bad = 0
    for page in sorted(pages):
        if page == Path(__file__).resolve() or REPORT in page.parents:
            continue
        for number, word in found(page.read_text(encoding="utf-8")):
            print(f"{page.relative_to(ROOT)}:{number}: {word}: write {PLAIN[word]}")
            bad = 1
    return bad


if __name__ == "__main__":
    sys.exit(main())
