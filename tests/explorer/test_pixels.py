"""Pixels of the diagram, as a browser draws them, against the growth rates of the package."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from chromium import WITHOUT_WEBGL, visit
from matplotlib.colors import to_rgb
from page_numbers import FAMILIES, LAWS, OPEN, REST, spectrum

from stability.base.looks import LIGHT, LOOKS

SEED = 20
pytestmark = pytest.mark.browser
PIXELS = """(places) => {
  const {view, diagram} = stabilityExplorer, c = diagram.canvas;
  const copy = Object.assign(document.createElement("canvas"), {width: c.width, height: c.height});
  const pen = copy.getContext("2d");
  pen.drawImage(c, 0, 0);
  const d = pen.getImageData(0, 0, c.width, c.height).data, x = view.axis("x"), y = view.axis("y");
  const {limit, linear, width, end} = diagram.scale;
  return {scale: {limit, linear, width, end}, found: places.map(([u, v]) => {
    const [i, j] = [Math.floor(u * c.width), Math.floor(v * c.height)], at = 4 * (j * c.width + i);
    const values = {...view.state.values};
    values[x.name] = x.value((i + 0.5) / c.width);
    values[y.name] = y.value(1 - (j + 0.5) / c.height);
    return [view.subject.array(values), [...d.slice(at, at + 4)]];
  })};
}"""
"""Points of a diagram and the colours of their pixels."""
RAMP = np.array([to_rgb(c) for c in LIGHT.ramp])


def shade(rate: float, scale: dict[str, float]) -> np.ndarray:
    """The colour of a growth rate, on the scale of the page."""
    size = abs(min(max(rate, -scale["limit"]), scale["limit"]))
    linear, width = scale["linear"], scale["width"]
    bent = width * size / linear if size <= linear else width + np.log10(size / linear)
    place = min(max(0.5 + 0.5 * np.sign(rate) * bent / scale["end"], 0.0), 1 - 1e-9) * 5
    i = int(place)
    return RAMP[i] + (place - i) * (RAMP[i + 1] - RAMP[i])


def off(pixel: np.ndarray, colour: np.ndarray, line: np.ndarray) -> float:
    """How far a pixel is from a colour that lines of another one may cover in part."""
    share = np.dot(pixel - colour, line - colour) / np.dot(line - colour, line - colour)
    return float(np.abs(colour + np.clip(share, 0, 0.7) * (line - colour) - pixel).max())


@pytest.mark.parametrize("script", ["", WITHOUT_WEBGL], ids=["shader", "without WebGL"])
@pytest.mark.parametrize("total", [600, pytest.param(20_400, marks=pytest.mark.long)])
def test_no_pixel_has_another_sign_or_decade_than_python(
    browser: Any, page_of_disk: Path, total: int, script: str
) -> None:
    """With every number of the page over its whole slider, and friction up to 1000."""
    generator, hatch = np.random.default_rng(SEED), np.array(to_rgb(LIGHT.hatch))
    fill, line = (np.array(to_rgb(c)) for c in LOOKS["undecided"].fill or ())
    views = [(f, law, *ends) for f in FAMILIES for law in LAWS for ends in ((3, 0.25), (1e3, 0.5))]
    each, compared, open_ = -(-total // len(views)), 0, 0
    with visit(browser, page_of_disk, script=script) as seen:
        for family, law, most, k in views:
            across = "at:0.02:1.55" if family == "tumbling" else "at:0.02:5"
            up = f"mu:0.02:{most}" if LAWS[law] else "k:0.05:0.5"
            link = f"#show={family}-{law}&k={k}&xaxis={across}&yaxis={up}"
            places = generator.uniform(0, 1, (each, 2)).tolist()
            seen.page.evaluate(OPEN, link)
            seen.page.evaluate(REST)
            answer = seen.page.evaluate(PIXELS, places)
            points = np.array([point for point, _ in answer["found"]])
            pixels = np.array([pixel for _, pixel in answer["found"]]) / 255
            known = spectrum(family, law, points)
            for point, pixel, verdict, values in zip(
                points.tolist(), pixels, known.verdict, known.eigenvalues, strict=True
            ):
                where = (family, law, point, pixel, verdict)
                assert pixel[3] == 1, where
                good = verdict.word in ("stable", "neutral")
                rate = values.real.max()
                if off(pixel[:3], fill, line) < 0.02 and abs(rate) < 1e-9 * np.abs(values).max():
                    open_ += 1
                    continue
                assert good == (verdict.word != "unstable")
                assert off(pixel[:3], shade(rate, answer["scale"]), hatch) < 0.02, where
                compared += 1
    assert open_ <= total // 1000 and compared > 0.99 * total
