"""Check every link of the built site to a place within it, the pages made by commands included."""

from __future__ import annotations

import re
import sys
from functools import cache
from pathlib import Path
from urllib.parse import unquote

SITE = Path(__file__).resolve().parents[2] / "build" / "site" / "html"


@cache
def anchors(page: Path) -> frozenset[str]:
    """Names of the places of a page."""
    return frozenset(re.findall(r'\bid="([^"]+)"', page.read_text(encoding="utf-8")))


def broken(site: Path = SITE) -> list[str]:
    """Links that lead to no file, or to no place of one."""
    found = set()
    for page in site.rglob("*.html"):
        if "_static" in page.relative_to(site).parts:
            continue  # templates of the theme
        for url in re.findall(r'(?:href|src)="([^"]+)"', page.read_text(encoding="utf-8")):
            if re.match(r"[a-z]+:|//", url):
                continue
            path, _, place = unquote(url).partition("#")
            target = (page.parent / path.split("?")[0]).resolve() if path else page
            there = target.exists()
            if there and place and target.suffix == ".html":
                there = place in anchors(target)
            if not there:
                found.add(f"{page.relative_to(site)}: {url}")
    return sorted(found)


if __name__ == "__main__":
    faults = broken()
    print(*faults, sep="\n", end="\n" * bool(faults))
    sys.exit(bool(faults))
