"""What keeps a figure from being printed: texts over texts, small or pale, legends over data."""

from itertools import combinations
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text

SMALLEST = 6.0
"""Size of the smallest text [pt]; exponents and indices are smaller, as in any journal."""
PALEST, PALEST_WORD = 3.0, 4.5
"""Least contrast with white, by the Web Content Accessibility Guidelines: of a number that may have
the colour of its curve, and of a word."""
# Machado, Oliveira & Fernandes, IEEE Trans. Vis. Comput. Graph. 15 (2009) 1291-1298, severity 1
DEFICIENT = {
    "protan": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deutan": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritan": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
"""Three deficiencies of colour vision, on linear light."""


def linear(colours: Any) -> Any:
    """Linear light of sRGB colours."""
    c = np.asarray(colours, dtype=float)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def luminance(light: Any) -> Any:
    """Relative luminance of linear sRGB."""
    return np.asarray(light) @ [0.2126729, 0.7151522, 0.0721750]


def lab(light: Any) -> Any:
    """CIE Lab of linear sRGB, white D65."""
    xyz = (
        light
        @ np.array(
            [
                [0.4124564, 0.2126729, 0.0193339],
                [0.3575761, 0.7151522, 0.1191920],
                [0.1804375, 0.0721750, 0.9503041],
            ]
        )
        / [0.95047, 1, 1.08883]
    )
    f = np.where(xyz > (6 / 29) ** 3, np.cbrt(xyz), xyz / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.stack(
        [116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])],
        axis=-1,
    )


def contrast(one: Any, other: Any = "white") -> float:
    """Contrast of two colours, 1 to 21, by the Web Content Accessibility Guidelines."""
    first, second = sorted(luminance(linear(to_rgb(c))) + 0.05 for c in (one, other))
    return float(second / first)


def seen(colour: Any) -> dict[str, Any]:
    """A colour in CIE Lab as readers see it: in grey, and with each deficiency."""
    light = linear(to_rgb(colour))
    by = {kind: np.clip(np.array(m) @ light, 0, 1) for kind, m in DEFICIENT.items()}
    return {kind: lab(v) for kind, v in (by | {"grey": np.full(3, luminance(light))}).items()}


def drawn(figure: Figure) -> list[tuple[Text, Any]]:
    """Every text as it is drawn, with its box in pixels."""
    found: list[tuple[Text, Any]] = []
    plain = Text.draw

    def draw(self: Text, renderer: Any, *rest: Any, **options: Any) -> None:
        if self.get_visible() and self.get_text().strip():
            # the text alone: an annotation would add its arrow
            found.append((self, Text.get_window_extent(self, renderer)))
        plain(self, renderer, *rest, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Text, "draw", draw)
        figure.set_dpi(200)
        FigureCanvasAgg(figure).draw()
    return found


def faults(
    figure: Figure, printed: float | None = None, texts: list[tuple[Text, Any]] | None = None
) -> list[str]:
    """Texts that overlap, leave the figure, are pale or too small; legends over data.

    A figure wider than `printed` [in] is scaled down to it; `texts` are those of `drawn`, where
    they are there already.
    """
    texts = drawn(figure) if texts is None else texts
    assert len(texts) > 2
    scale = min(1.0, (printed or np.inf) / figure.get_figwidth())
    said = [
        f"{t.get_text()!r} has {size:.3g} pt"
        for t, _ in texts
        if (size := scale * t.get_fontsize()) < SMALLEST - 1e-9
    ]
    said += [
        f"{t.get_text()!r} is pale"
        for t, _ in texts
        if contrast(t.get_color()) < (PALEST if t.get_text().isdigit() else PALEST_WORD)
    ]
    for (a, one), (b, other) in combinations(texts, 2):
        wide = min(one.x1, other.x1) - max(one.x0, other.x0)
        tall = min(one.y1, other.y1) - max(one.y0, other.y0)
        if wide > 1 and tall > 1:
            said.append(f"{a.get_text()!r} over {b.get_text()!r} by {wide:.0f} x {tall:.0f}")
    page = figure.bbox
    for text, box in texts:
        if min(box.x0, box.y0) < -1 or box.x1 > page.x1 + 1 or box.y1 > page.y1 + 1:
            said.append(f"{text.get_text()!r} leaves the figure")
    for axes in figure.axes:
        legend = axes.get_legend()
        box = legend.get_window_extent() if legend else None
        said += [
            f"the legend of {axes.get_ylabel()!r} covers data"
            for other in figure.axes
            if box is not None
            and box.y0 < other.bbox.y1 - 1
            and box.y1 > other.bbox.y0 + 1
            and box.x0 < other.bbox.x1 - 1
            and box.x1 > other.bbox.x0 + 1
        ]
    return said
