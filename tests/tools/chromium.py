"""A Chromium of the system, driven by Playwright; what a page says, asks for or raises is kept."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
ARGUMENTS = (
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
SOFTWARE = (
    "--disable-gpu",
    "--enable-unsafe-swiftshader",
    "--use-gl=angle",
    "--use-angle=swiftshader",
)
GPU = ("--enable-gpu", "--ignore-gpu-blocklist", "--use-gl=angle")
"""With `--use-angle=`: gl-egl or vulkan on Linux, d3d11 on Windows, metal on macOS."""
DESKTOP, PHONE = {"width": 1280, "height": 800}, {"width": 390, "height": 844}
WITHOUT_WEBGL = (
    "const own = HTMLCanvasElement.prototype.getContext;"
    "HTMLCanvasElement.prototype.getContext = function (kind, ...more) {"
    "return kind.startsWith('webgl') ? null : own.call(this, kind, ...more); };"
)


def executable() -> str:
    """Path of the browser; without one the test fails, and says what to install."""
    for name in NAMES:
        if found := shutil.which(name):
            return found
    pytest.fail(
        "no Chromium is installed, which the tests of the explorer drive; say `apt-get install "
        "chromium`, or put a program named chromium or google-chrome on the path.",
        pytrace=False,
    )


@contextmanager
def chromium(*more: str, rendering: Sequence[str] = SOFTWARE) -> Iterator[Any]:
    """A headless browser, which draws in software unless told otherwise."""
    from playwright.sync_api import sync_playwright

    path = executable()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=path, headless=True, args=[*ARGUMENTS, *rendering, *more]
        )
        try:
            yield browser
        finally:
            browser.close()


@dataclass
class Visit:
    """A page, and what it did."""

    page: Any
    """The page of Playwright."""
    said: list[str] = field(default_factory=list)
    """Errors and warnings of its console, and its exceptions."""
    asked: list[str] = field(default_factory=list)
    """Addresses that it asked for, its own left out."""


@contextmanager
def visit(
    browser: Any,
    path: Path,
    link: str = "",
    *,
    size: dict[str, int] | None = None,
    script: str = "",
    ready: bool = True,
    **context: Any,
) -> Iterator[Visit]:
    """Open a page from its file; every request that leaves it is refused, and kept.

    Without another wish nothing moves by itself, which software rendering would draw all the time.
    """
    home = browser.new_context(
        **{"viewport": size or DESKTOP, "reduced_motion": "reduce"} | context
    )
    page = home.new_page()
    if script:
        page.add_init_script(script)
    found = Visit(page)

    def said(message: Any) -> None:
        # software rendering makes the browser itself remark on the speed of reading pixels
        if (
            message.type in ("error", "warning")
            and "GPU stall due to ReadPixels" not in message.text
        ):
            found.said.append(message.text)

    def asked(route: Any) -> None:
        address = route.request.url
        if address.startswith(path.as_uri()) or address.startswith(("data:", "blob:")):
            route.continue_()
        else:
            found.asked.append(address)
            route.abort()

    page.on("console", said)
    page.on("pageerror", lambda error: found.said.append(str(error)))
    page.route("**/*", asked)
    page.goto(path.as_uri() + link)
    if ready:
        page.wait_for_selector("[data-ready]", timeout=60_000)
    try:
        yield found
    finally:
        home.close()
