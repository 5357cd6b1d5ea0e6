"""How each verdict looks, and each mark of an answer: the one table for figures, reports and pages.

Whoever draws reads `LOOKS` while it draws, so that a change of a row changes every figure, the
tables of a report, and the style sheet, data and shader of the explorer's page.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

BLUE, VERMILION, GREEN, PURPLE, SKY = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9"
"""Colours of Okabe and Ito, safe for colour-blind readers."""
YELLOW, OCHRE = "#f7d038", "#6b5900"
"""Colours of what lies on a boundary, and of its edge: no colours of growth or decay."""

PATTERNS = {
    "": "",
    "slanted lines": "////",
    "dots": "....",
    "crosses": "xxxx",
    "level lines": "----",
}
"""Hatchings of regions by name, as Matplotlib takes them; the explorer's `patterns.js` has each."""


HATCHES = {
    "second family": ("||||", "upright lines"),
    "third family": ("||..", "upright lines and dots"),
    "fourth family": ("--..", "level lines and dots"),
    "moving": (r"\\\\", "lines that fall"),
    "flat": (r"||\\", "upright and falling lines"),
    "lift-off": ("oo", "small circles"),
    "no-contact": ("OO", "large circles"),
    "non-unique": ("**", "stars"),
    "domain-end": (r"\\..", "falling lines and dots"),
    "unresolved": ("//..", "slanted lines and dots"),
    "undetermined": ("xx..", "crosses and dots"),
    "wrong": ("+++++", "upright crosses"),
    "late": ("//oo", "slanted lines and circles"),
    "turns back": ("//||", "slanted and upright lines"),
}
"""Hatching and its name for what is no verdict; none has that of a verdict or of another."""


@dataclass(frozen=True)
class Tones:
    """Colours that tell growth from decay, on one background.

    Decay is blue, growth vermilion: distinct in every common colour vision.  In grey growth never
    gets as dark as decay, and its hatching is dark on every shade of it.
    """

    ramp: tuple[str, ...]
    """Colours of growth rates at equal steps, from the fastest decay to the fastest growth."""
    hatch: str
    """Colour of hatching."""
    decay: str
    """Colour of words and dots that tell of decay."""
    growth: str
    """Colour of words and dots that tell of growth."""


LIGHT = Tones(
    ("#08306b", "#4292c6", "#deebf7", "#fdebdc", "#f2a072", "#c8521c"),
    hatch="#2b1000",
    decay="#2a6ea8",
    growth="#c8521c",
)
"""On white."""
DARK = Tones(
    ("#b9dcff", "#4a93cf", "#16314c", "#3a2114", "#c8602a", "#ffc7a1"),
    hatch="#ffe6d5",
    decay="#6db2e6",
    growth="#f09a5c",
)
"""On a dark page."""


@dataclass(frozen=True)
class Look:
    """How a verdict looks, or the mark of an answer in a comparison."""

    sign: str
    """Sign next to its word, or in its place."""
    word: str = ""
    """Word of what is no verdict, where that is not its name in the table."""
    pattern: str = ""
    """Hatching of its regions, a key of `PATTERNS`."""
    shade: float = 0.5
    """Place on the ramp of growth rates, 0 to 1, where no rate is known."""
    tone: str = "ink"
    """Colour of its word on the explorer's page: decay, growth, quiet or ink."""
    border: str = "solid"
    """Line about its word there."""
    fill: tuple[str, str] | None = None
    """Colours of the inside, and of lines, of its regions and proved boxes; None for regions in the
    colours of growth rates and boxes of an outline alone."""
    cell: tuple[str, str] = ("", "")
    """Colour and hatching of its share of the answers in a report."""

    @property
    def hatching(self) -> str:
        """The hatching of its regions, as Matplotlib takes it; empty for none."""
        return PATTERNS[self.pattern]


LOOKS: dict[str, Look] = {
    "stable": Look("✓", tone="decay", shade=0.325),
    "unstable": Look("↗", tone="growth", shade=0.75, pattern="slanted lines"),
    "neutral": Look("○", tone="decay", pattern="dots"),
    "undecided": Look(
        "?",
        pattern="crosses",
        tone="quiet",
        border="dashed",
        fill=(YELLOW, OCHRE),
        cell=("#e2e2e2", "xxxxx"),
    ),
    "drifting": Look("→", tone="growth", pattern="level lines"),
    "absent": Look("–", word="no member"),
    # marks of answers in a comparison of methods; `undecided` is both
    "right": Look("✓", cell=("#2b6ca3", "")),
    "degraded": Look("≈", cell=("#8fb9dd", "")),
    "refused": Look("–", cell=("#f6f6f6", "")),
    "wrong": Look("✗", cell=(PURPLE, HATCHES["wrong"][0])),
    "crashed": Look("‼", cell=("#000000", "")),
    "late": Look("…", cell=("#b0b0b0", HATCHES["late"][0])),
}
"""The look of each verdict, of a place without a member, and of each mark, by its word."""
SHOWN = ("stable", "unstable", "neutral", "undecided", "drifting", "absent")
"""What the explorer's page shows at a point."""


def page_looks() -> dict[str, Any]:
    """The table as the explorer's page reads it: words, signs, hatchings, and tones."""
    return {
        "verdicts": {
            word: {
                "word": LOOKS[word].word or word,
                "sign": LOOKS[word].sign,
                "pattern": LOOKS[word].pattern,
            }
            for word in SHOWN
        },
        "tones": {
            name: {"ramp": tones.ramp, "hatch": tones.hatch, "undecided": LOOKS["undecided"].fill}
            for name, tones in (("light", LIGHT), ("dark", DARK))
        },
    }


def page_style() -> str:
    """The table as rules of the explorer's style sheet."""

    def variables(tones: Tones) -> str:
        return f".explorer {{ --decay: {tones.decay}; --growth: {tones.growth}; }}"

    badges = [
        f".explorer .badge.{word} {{ color: var(--{LOOKS[word].tone}); "
        f"border-style: {LOOKS[word].border}; }}"
        for word in SHOWN
    ]
    dark = f"@media (prefers-color-scheme: dark) {{ {variables(DARK)} }}"
    return "\n".join([variables(LIGHT), dark, *badges])


def cell_style(words: Iterable[str]) -> str:
    """Rules of a style sheet for the cells of a report, by the words of marks.

    Examples
    --------
    >>> cell_style(["wrong", "crashed"]).splitlines()
    ['.wrong { background: #cc79a7; color: #000; }', '.crashed { background: #000000; color: #fff; }']
    """  # noqa: E501
    rules = []
    for word in words:
        colour, _ = LOOKS[word].cell
        red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
        light = 0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2
        ink = "#000" if light > 0.18 else "#fff"  # the better contrast
        rules.append(f".{word} {{ background: {colour}; color: {ink}; }}")
    return "\n".join(rules)
