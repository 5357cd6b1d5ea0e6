"""What keeps a figure from being printed: texts over texts, small texts, legends over data."""

from itertools import combinations
from typing import Any

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

SMALLEST = 6.0
"""Size of the smallest text [pt]; exponents and indices are smaller, as in any journal."""


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


def faults(figure: Figure) -> list[str]:
    """Texts that overlap, leave the figure or are too small; legends over data."""
    texts = drawn(figure)
    assert len(texts) > 8
    said = [f"{t.get_text()!r} has {t.get_fontsize()} pt"
            for t, _ in texts if t.get_fontsize() < SMALLEST]  # fmt: skip
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
        said += [f"the legend of {axes.get_ylabel()!r} covers data" for other in figure.axes
                 if box is not None and box.y0 < other.bbox.y1 - 1 and box.y1 > other.bbox.y0 + 1
                 and box.x0 < other.bbox.x1 - 1 and box.x1 > other.bbox.x0 + 1]  # fmt: skip
    return said
