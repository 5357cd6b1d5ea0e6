"""Pages of HTML: a head with the common style, and a figure with its caption and files."""

from __future__ import annotations

import html
from collections.abc import Mapping

STYLE = """
:root { color-scheme: light dark; --ink: #1a1a1a; --quiet: #444; --page: #fff; --rule: #ccc;
        --link: #0645ad; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e8e8; --quiet: #b8b8b8; --page: #161616; --rule: #444; --link: #8ab4f8; } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--page);
       max-width: 76rem; margin: 0 auto; padding: 1.5rem; }
a { color: var(--link); }
h1 { font-size: 1.6rem; margin: 0 0 .5rem; }
figure { margin: 0; } figure img { width: 100%; height: auto; display: block;
             background: #fff; }
figcaption { font-size: .85rem; color: var(--quiet); } figcaption .files { white-space: nowrap; }
figcaption summary { cursor: pointer; }
footer { margin-top: 3rem; border-top: 1px solid var(--rule); font-size: .82rem;
         color: var(--quiet); }
"""
"""Rules of every page; those of one page come after them."""


def head(title: str, style: str, heading: str = "") -> list[str]:
    """The first lines of a page: its title, its own rules of style, and its heading.

    Examples
    --------
    >>> head("A page", "p { margin: 0; }")[-1]
    '<h1>A page</h1>'
    """
    return [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{title}</title><style>{STYLE}{style}</style>",
        "</head><body>",
        f"<h1>{heading or title}</h1>",
    ]


def unbroken(text: str) -> str:
    """Text for a page, in which no line ends within an equation or a fraction.

    Examples
    --------
    >>> unbroken("k = 1/2").count("\u00a0")
    2
    """
    return html.escape(text).replace(" = ", "\u00a0=\u00a0").replace("/√", "/\u2060√")


def figure(
    stem: str, caption: str, alternative: str, files: Mapping[str, str], exact: str = ""
) -> str:
    """A figure with its caption, links to its files, and an exact description to open."""
    links = " · ".join(f'<a href="{stem}.{ending}">{word}</a>' for ending, word in files.items())
    more = f"<details><summary>exactly</summary>{html.escape(exact)}</details>" if exact else ""
    return (
        f'<figure><img src="{stem}.png" alt="{html.escape(alternative)}" loading="lazy">'
        f'<figcaption>{unbroken(caption)} <span class="files">{links}</span>{more}</figcaption>'
        "</figure>"
    )
