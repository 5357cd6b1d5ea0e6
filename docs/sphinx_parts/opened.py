"""Open the built site in a browser, from its files: `make docs-opened`, after `make docs`.

Each page is opened at the width of a phone and, dark, of a desktop.  It must say nothing on its
console, ask for nothing outside the site, be no wider than the window, and squash no picture.
Search must find.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

SITE = Path(__file__).resolve().parents[2] / "build" / "site" / "html"
ALONE = ("atlas", "report", "explorer", "made")
"""Folders of pages that are shown in frames of others."""
LOOKS = {
    "phone": {"viewport": {"width": 390, "height": 844}, "color_scheme": "light"},
    "desktop": {"viewport": {"width": 1280, "height": 900}, "color_scheme": "dark"},
}
SQUASHED = """Array.from(document.images).filter(
  i => i.naturalHeight && i.clientHeight
    && Math.abs(i.clientWidth / i.clientHeight * i.naturalHeight / i.naturalWidth - 1) > 0.05
).map(i => i.getAttribute('src'))"""
"""Pictures that are shown with other proportions than their own; small ones are a pixel off."""
SEARCHES = {"flutter": "tutorials/", "stability_map": "reference/maps.html", "hysteresis": ""}
"""A word, and how the address of a page that it finds starts; "" where it finds nothing."""


def pages(site: Path = SITE) -> list[Path]:
    """The pages with the site's own frame around them, and those of the frames."""
    found = sorted(site.rglob("*.html"))
    return [p for p in found if p.relative_to(site).parts[0] != "_static"]


def faults(browser: Any, site: Path = SITE) -> Iterator[str]:
    """One line for each fault of a page."""
    for look, settings in LOOKS.items():
        home = browser.new_context(**settings, reduced_motion="reduce")
        page, said = home.new_page(), []
        _listen(page, said)
        for path in pages(site):
            _open(page, path, said)
            yield from (f"{path.relative_to(site)} ({look}): {fault}" for fault in said)
            said.clear()
        home.close()


def _listen(page: Any, said: list[str]) -> None:
    """Keep what a page says, asks for and misses."""

    def heard(message: Any) -> None:  # software rendering makes the browser remark on its speed
        if message.type in ("error", "warning") and "ReadPixels" not in message.text:
            said.append(f"says {message.text!r}")

    def asked(request: Any) -> None:
        if not request.url.startswith(("file:", "data:", "blob:")):
            said.append(f"asks for {request.url}")

    page.on("console", heard)
    page.on("pageerror", lambda error: said.append(f"fails: {error}"))
    page.on("request", asked)
    page.on("requestfailed", lambda request: said.append(f"misses {request.url}"))


def _open(page: Any, path: Path, said: list[str]) -> None:
    """Open a page with its frames, and add what is wrong with its looks."""
    page.goto(path.as_uri())
    for frame in page.query_selector_all("iframe"):
        frame.scroll_into_view_if_needed()  # frames load when they are seen
        inside = frame.content_frame()
        inside.wait_for_load_state()
        if not inside.query_selector("body *"):
            said.append(f"has an empty frame {frame.get_attribute('src')}")
    wide = page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
    if wide > 0:
        said.append(f"is {wide} pixels too wide")
    said += [f"squashes {source}" for source in page.evaluate(SQUASHED)]


def searched(browser: Any, site: Path = SITE) -> Iterator[str]:
    """One line for each word that the search of the site does not answer."""
    home = browser.new_context()
    for word, wanted in SEARCHES.items():
        yield from _of_search(home.new_page(), site, word, wanted)
    home.close()


def _of_search(page: Any, site: Path, word: str, wanted: str) -> Iterator[str]:
    page.goto(f"{(site / 'search.html').as_uri()}?q={word}")
    page.wait_for_function("document.querySelector('#search-results p')?.textContent.trim()")
    page.wait_for_timeout(3000)
    links = page.eval_on_selector_all("#search-results li a", "all => all.map(a => a.href)")
    found = [link.removeprefix(f"{site.as_uri()}/") for link in links]
    if not any(link.startswith(wanted) for link in found) if wanted else found:
        yield f"search for {word!r} finds {found}"


def main() -> int:
    """Print the faults."""
    sys.path.insert(0, str(SITE.parents[2] / "tests" / "tools"))
    from chromium import chromium

    if not (SITE / "index.html").is_file():
        print(f"{SITE} has no site; say make docs")
        return 1
    with chromium() as browser:
        found = [*faults(browser), *searched(browser)]
    print(*found, sep="\n", end="\n" * bool(found))
    print(f"{len(pages())} pages opened at two widths, {len(found)} faults")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
