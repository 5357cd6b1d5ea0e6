"""The page in Chromium: every control, keyboard, touch, link, export, and what it asks for."""

import json
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from chromium import DESKTOP, PHONE, WITHOUT_WEBGL, visit
from page_numbers import REST
from towed_wheel import GIVEN, towed_wheel

import stability as st

STATE = "() => stabilityExplorer.view.state"


def state(seen: Any) -> dict[str, Any]:
    found: dict[str, Any] = seen.page.evaluate(STATE)
    return found


def rest(seen: Any) -> None:
    seen.page.evaluate(REST)


def quiet(seen: Any) -> None:
    """No error, no warning, and no request that leaves the page."""
    rest(seen)
    assert not seen.said
    assert not seen.asked


def test_every_family_and_law_is_drawn(browser: Any, page_of_disk: Path) -> None:
    with visit(browser, page_of_disk) as seen:
        page, shown = seen.page, set()
        for family in ("Rolling", "Spinning", "Tumbling"):
            page.get_by_role("radio", name=family).click()
            for law in ("Smooth", "Viscous", "Linear", "Rough"):
                page.get_by_role("radio", name=law).click()
                rest(seen)
                shown.add((page.locator("h1").inner_text(), state(seen)["subject"]))
                assert page.get_by_role("radio", name=law).get_attribute("aria-checked") == "true"
                assert page.locator(".badge").inner_text().split()[-1] in (
                    "stable",
                    "unstable",
                    "neutral",
                )
                assert page.locator(".mode").count() >= 1
        assert len(shown) == 12
        quiet(seen)


def test_sliders_and_numbers_move_the_point(browser: Any, page_of_disk: Path) -> None:
    with visit(browser, page_of_disk) as seen:
        page = seen.page
        for name, label in (
            ("at", "precession rate φ̇"),
            ("mu", "friction coefficient μ"),
            ("k", "inertia factor k"),
        ):
            before = state(seen)["values"][name]
            page.get_by_label(label, exact=True).focus()
            for _ in range(12):
                page.keyboard.press("ArrowRight")
            rest(seen)
            assert state(seen)["values"][name] > before
            number = page.get_by_label(f"{label}, number")
            number.fill("0.4")
            number.press("Enter")
            rest(seen)
            assert state(seen)["values"][name] == 0.4
        number.fill("0.7")  # no thin body has this inertia factor
        number.press("Enter")
        rest(seen)
        assert number.get_attribute("aria-invalid") == "true"
        reason = page.get_by_role("alert")
        assert reason.inner_text() == "give a number above 0 and at most 0.5"
        assert number.input_value() == "0.7" and state(seen)["values"]["k"] == 0.4
        slider = page.get_by_label("inertia factor k", exact=True)
        slider.dispatch_event("pointerdown")
        slider.evaluate("(e) => { e.value = 890; e.dispatchEvent(new Event('input')); }")
        rest(seen)
        assert state(seen)["values"]["k"] == 0.25  # a slider rests at a value with a name
        assert reason.count() == 0
        said = page.locator(".sliders").inner_text()
        assert "uniform disk" in said and "friction coefficient [1/√(gR)]" in said
        quiet(seen)


def test_axes_are_chosen_and_limited(browser: Any, page_of_disk: Path) -> None:
    with visit(browser, page_of_disk) as seen:
        page = seen.page
        page.get_by_text("Axes", exact=True).click()
        page.get_by_label("Vertical axis").select_option("k")
        assert state(seen)["y"] == "k"
        page.get_by_label("Horizontal axis").select_option("k")
        assert (state(seen)["x"], state(seen)["y"]) == ("k", "at")  # they change places
        upper = page.get_by_label("inertia factor k, upper end of the axis")
        upper.fill("0.4")
        upper.press("Enter")
        assert state(seen)["ranges"]["k"][1] == 0.4
        upper.fill("-3")  # below the lower end
        upper.press("Enter")
        assert state(seen)["ranges"]["k"][1] == 0.4
        quiet(seen)


def test_a_logarithmic_axis_is_drawn_linked_and_asked_of_python(
    browser: Any, page_of_disk: Path
) -> None:
    with visit(browser, page_of_disk, "#show=rolling-viscous&at=1.2&k=0.25") as seen:
        page = seen.page
        page.get_by_text("Axes", exact=True).click()
        page.get_by_label("axial angular velocity ω₃, logarithmic axis").check()
        rest(seen)
        low, high, spacing = state(seen)["ranges"]["at"]
        assert spacing == "log"
        # the boundary 2kω₃² = 1 stands where its logarithm says, in the drawing and in the colours
        place = np.log(np.sqrt(2.0) / low) / np.log(high / low)
        box = page.locator(".diagram-stage canvas").bounding_box()
        line = page.locator("path.boundary").first.bounding_box()
        assert line["x"] + line["width"] / 2 - box["x"] == pytest.approx(
            place * box["width"], abs=1.5
        )
        warm = page.locator(".diagram-stage canvas").evaluate(WARMEST, float(place))
        assert warm[0] > 12 and warm[1] < -12
        assert page.locator(".over .number", has_text="0.1").count() >= 1
        page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
        rest(seen)
        assert state(seen)["values"]["at"] == pytest.approx(np.sqrt(low * high), rel=0.02)
        page.mouse.wheel(0, -200)
        rest(seen)
        assert state(seen)["ranges"]["at"][2] == "log"
        page.get_by_role("button", name="Python").click()
        code = page.locator("pre").inner_text()
        assert re.search(r'x=\("at", [\d.]+, [\d.]+, 300, "log"\)', code)
        page.wait_for_timeout(400)
        kept, link = state(seen), page.evaluate("location.hash")
        quiet(seen)
    with visit(browser, page_of_disk, link) as seen:
        assert state(seen) == kept
        lower = seen.page.get_by_label("axial angular velocity ω₃, lower end of the axis")
        seen.page.get_by_text("Axes", exact=True).click()
        lower.fill("-1")  # no logarithm
        lower.press("Enter")
        assert state(seen)["ranges"]["at"][0] > 0
        quiet(seen)


WARMEST = """(c, place) => {
  const copy = document.createElement("canvas"), pen = copy.getContext("2d");
  copy.width = 100;
  copy.height = 1;
  pen.drawImage(c, 0, 0, 100, 1);
  const d = pen.getImageData(0, 0, 100, 1).data;
  const at = [-8, 8].map((by) => 4 * Math.round(100 * place + by));
  return at.map((i) => d[i] - d[i + 2]);
}"""
"""Red less blue, left and right of a place."""


def test_hand_and_keys_work_on_the_diagram(browser: Any, page_of_disk: Path) -> None:
    with visit(browser, page_of_disk) as seen:
        page, stage = seen.page, seen.page.locator(".diagram-stage")
        box = stage.bounding_box()
        page.mouse.click(box["x"] + 0.3 * box["width"], box["y"] + 0.5 * box["height"])
        first = state(seen)["values"]
        rest(seen)
        assert page.locator(".badge").inner_text().endswith("unstable")
        page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.5 * box["height"])
        page.mouse.down()
        page.mouse.move(box["x"] + 0.8 * box["width"], box["y"] + 0.8 * box["height"], steps=4)
        page.mouse.up()
        rest(seen)
        assert state(seen)["values"]["at"] > first["at"]
        assert page.locator(".badge").inner_text().endswith("stable")
        page.mouse.wheel(0, -300)
        rest(seen)
        low, high = state(seen)["ranges"]["at"]
        assert high - low < 4.9
        stage.dblclick(position={"x": 200, "y": 200})
        assert state(seen)["ranges"]["at"] == [0.02, 5]
        stage.focus()
        for key, name, sign in (
            ("ArrowRight", "at", 1),
            ("ArrowLeft", "at", -1),
            ("ArrowUp", "mu", 1),
            ("Shift+ArrowDown", "mu", -1),
        ):
            before = state(seen)["values"][name]
            page.keyboard.press(key)
            assert sign * (state(seen)["values"][name] - before) > 0
        page.keyboard.press("+")
        assert state(seen)["ranges"]["at"][1] - state(seen)["ranges"]["at"][0] < 4.9
        page.keyboard.press("0")
        assert state(seen)["ranges"]["at"] == [0.02, 5]
        page.wait_for_function(
            "document.getElementById('stability-said').innerText.includes('at φ̇')"
        )
        assert "at φ̇" in page.locator("#stability-said").inner_text()  # a reader hears it
        quiet(seen)


def test_every_control_is_reached_by_tab(browser: Any, page_of_disk: Path) -> None:
    with visit(browser, page_of_disk) as seen:
        page, reached = seen.page, []
        for _ in range(60):
            page.keyboard.press("Tab")
            name, outline = page.evaluate(
                "() => { const e = document.activeElement;"
                "const text = e.tagName === 'BODY' ? '' : e.innerText;"
                "return [e.getAttribute('aria-label') || text || e.tagName,"
                "getComputedStyle(e).outlineStyle]; }"
            )
            if reached and name == reached[0]:
                break
            assert outline != "none" or name == "BODY", name
            reached.append(name)
        said = "\n".join(reached)
        for word in (
            "Spinning",
            "Viscous",
            "Link",
            "SVG",
            "PNG",
            "Python",
            "Stability diagram",
            "friction",
            "Launch",
            "Play",
            "Time",
            "Length of the run",
        ):
            assert word in said, word


def test_modes_and_paths_of_eigenvalues(browser: Any, page_of_disk: Path) -> None:
    with visit(browser, page_of_disk) as seen:
        page = seen.page
        for i in range(3):
            page.locator(".mode").nth(i).click()
            rest(seen)
            assert state(seen)["mode"] == i
            assert f"Mode {i + 1}" in page.locator(".outcome").inner_text()
        page.keyboard.press("ArrowUp")
        assert state(seen)["mode"] == 1
        paths = page.locator(".locus").first.get_attribute("d")
        page.get_by_label("Quantity whose change moves").select_option("k")
        rest(seen)
        assert page.locator(".locus").first.get_attribute("d") != paths
        dot = page.locator("circle.value").first.bounding_box()
        page.mouse.click(dot["x"] + dot["width"] / 2, dot["y"] + dot["height"] / 2)
        assert state(seen)["show"] == "mode"
        quiet(seen)


def test_a_launch_is_played_and_ends_as_python_says(browser: Any, page_of_disk: Path) -> None:
    link = "#show=spinning-viscous&at=5&mu=0.3&k=0.25&tilt=0.6&time=20&picture=launch"
    with visit(browser, page_of_disk, link, reduced_motion="no-preference") as seen:
        page = seen.page
        rest(seen)
        start = st.launch("spinning", at=5.0, tilt=0.6)
        run = st.simulate(st.Disk(), st.Viscous(0.3), start, 20.0, check=False)
        said = page.locator(".outcome").inner_text()
        assert run.attrs["outcome"] == "lift-off" and "leaves the plane" in said
        assert f"t = {float(run.end_time):.5g} " in said
        page.get_by_label("Size of the disturbance").evaluate(
            "(e) => { e.value = 300; e.dispatchEvent(new Event('input')); }"
        )
        rest(seen)
        assert state(seen)["tilt"] < 0.1
        assert "the run ends" in page.locator(".outcome").inner_text()
        page.get_by_label("Length of the run").select_option("60")
        rest(seen)
        assert "t = 60" in page.locator(".outcome").inner_text()
        page.get_by_label("Play or pause").click()
        page.get_by_label("Time", exact=True).evaluate(
            "(e) => { e.value = 500; e.dispatchEvent(new Event('input')); }"
        )
        rest(seen)
        assert page.locator(".clock").first.inner_text() == "t = 30.0"
        assert page.locator(".trace").count() == 2
        for name in ("Steady", "Mode", "Launch"):
            page.get_by_role("radio", name=name).click()
            rest(seen)
            assert state(seen)["show"] == name.lower()
        quiet(seen)


def test_a_link_restores_the_view(browser: Any, page_of_disk: Path) -> None:
    with visit(browser, page_of_disk) as seen:
        page = seen.page
        page.get_by_role("radio", name="Tumbling").click()
        page.get_by_label("Size of the disturbance").evaluate(
            "(e) => { e.value = 700; e.dispatchEvent(new Event('input')); }"
        )
        page.locator(".diagram-stage").click(position={"x": 260, "y": 130})
        page.mouse.wheel(0, -200)
        page.locator(".mode").nth(1).click()
        rest(seen)
        page.wait_for_timeout(400)  # the link follows a little later
        kept, link = state(seen), page.evaluate("location.hash")
    with visit(browser, page_of_disk, link) as seen:
        assert state(seen) == kept
        seen.page.evaluate(
            "location.hash = '#show=rolling-rough&at=0.9&k=nonsense&mode=99&xaxis=foo:1:2'"
        )
        rest(seen)
        found = state(seen)
        assert (found["subject"], found["values"]) == ("rolling rough", {"at": 0.9, "k": 0.25})
        quiet(seen)


def test_the_picture_is_saved_and_the_call_reproduces_the_point(
    browser: Any, page_of_disk: Path
) -> None:
    with visit(browser, page_of_disk, accept_downloads=True) as seen:
        page = seen.page
        with page.expect_download() as waiting:
            page.get_by_role("button", name="SVG").click()
        drawing = ElementTree.fromstring(Path(waiting.value.path()).read_text(encoding="utf-8"))
        tags = {e.tag.split("}")[1] for e in drawing.iter()}
        assert {"image", "path", "text"} <= tags
        words = "".join(drawing.itertext())
        assert "stable" in words
        title = drawing.find("{http://www.w3.org/2000/svg}title")
        assert title is not None and title.text
        assert {"spinning,", "viscous", "float"} <= set(re.split(r"[ ():]", title.text))
        assert "k = 0." in title.text
        with page.expect_download() as waiting:
            page.get_by_role("button", name="PNG").click()
        assert Path(waiting.value.path()).read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
        page.get_by_role("button", name="Python").click()
        code = page.locator("pre").inner_text()
        page.get_by_role("button", name="Copy").click()
        rest(seen)
        assert "copied" in page.locator(".exports").inner_text()
        quiet(seen)
        verdict = page.locator(".badge").inner_text().split()[-1]
    space: dict[str, Any] = {}
    exec(
        re.sub(
            r"300\), y=|200\), ", lambda m: m.group().replace("300", "6").replace("200", "5"), code
        ),
        space,
    )  # noqa: S102
    assert space["point"].verdict.word == verdict
    assert space["diagram"].abscissa.shape == (5, 6)
    assert space["motion"].attrs["outcome"] in ("moving", "settled")


@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=["desktop", "phone"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_is_wider_than_the_screen_and_colours_follow(
    browser: Any, page_of_disk: Path, size: dict[str, int], scheme: str
) -> None:
    with visit(browser, page_of_disk, size=size, color_scheme=scheme) as seen:
        page = seen.page
        assert page.evaluate("document.documentElement.scrollWidth") <= size["width"]
        red = page.evaluate(
            "Number(getComputedStyle(document.querySelector('.explorer'))"
            ".backgroundColor.match(/\\d+/)[0])"
        )
        assert (red < 60) == (scheme == "dark")
        small = page.evaluate(
            "[...document.querySelectorAll('button, select, input')]"
            ".filter((e) => e.getClientRects().length && e.getBoundingClientRect().height < 24)"
            ".map((e) => e.outerHTML.slice(0, 80))"
        )
        assert not small  # large enough for a finger
        quiet(seen)


def test_touch_moves_the_point(browser: Any, page_of_disk: Path) -> None:
    with visit(browser, page_of_disk, size=PHONE, has_touch=True) as seen:
        box = seen.page.locator(".diagram-stage").bounding_box()
        seen.page.touchscreen.tap(box["x"] + 0.8 * box["width"], box["y"] + 0.3 * box["height"])
        rest(seen)
        assert state(seen)["values"]["at"] > 3
        quiet(seen)


def test_reduced_motion_stands_still(browser: Any, page_of_disk: Path) -> None:
    for wish in ("reduce", "no-preference"):
        with visit(browser, page_of_disk, reduced_motion=wish) as seen:
            seen.page.wait_for_timeout(300)
            still = seen.page.locator(".clock").first.inner_text() == "t = 0.0"
            assert still == (wish == "reduce")
            quiet(seen)


def test_without_webgl_the_same_diagram_is_painted(browser: Any, page_of_disk: Path) -> None:
    pixels = (
        "() => { const c = document.querySelector('.diagram-stage canvas');"
        "const copy = document.createElement('canvas'); copy.width = 60; copy.height = 40;"
        "const pen = copy.getContext('2d'); pen.drawImage(c, 0, 0, 60, 40);"
        "return Array.from(pen.getImageData(0, 0, 60, 40).data); }"
    )
    pictures = []
    for script in ("", WITHOUT_WEBGL):
        with visit(browser, page_of_disk, script=script) as seen:
            rest(seen)
            pictures.append(seen.page.evaluate(pixels))
            assert "double precision" in seen.page.locator(".hint").first.inner_text()
            if script:  # the disk is painted too, in its blue
                drawn = seen.page.locator(".motion-stage canvas").evaluate(
                    "(c) => { const pen = c.getContext('2d');"
                    "const d = pen.getImageData(0, 0, c.width, c.height).data;"
                    "let n = 0; for (let i = 0; i < d.length; i += 4) n += d[i + 2] - d[i] > 100;"
                    "return n / (c.width * c.height); }"
                )
                assert 0.02 < drawn < 0.5
            quiet(seen)
    # hatching falls on other pixels; warm means growth and cold means decay in both
    warm = [[p[4 * i] - p[4 * i + 2] for i in range(2400)] for p in pictures]
    clear = [(a, b) for a, b in zip(*warm, strict=True) if abs(a) > 12]
    assert len(clear) > 2000
    assert sum(a * b > 0 for a, b in clear) > 0.98 * len(clear)


def test_the_page_of_ones_own_family(browser: Any, tmp_path: Path) -> None:
    path = st.explore(
        towed_wheel(),
        at=0.3,
        x=("v", 0.1, 20),
        y=("trail", 0.02, 0.3),
        out=tmp_path / "own.html",
        **GIVEN,
    )
    with visit(browser, path) as seen:
        page = seen.page
        assert "straight" in page.locator("h1").inner_text().lower()
        assert page.locator(".slider:not(.tilt)").count() == 7
        page.locator(".diagram-stage").click(position={"x": 300, "y": 100})
        rest(seen)
        assert page.locator(".trace").count() >= 3
        page.get_by_label("State that is disturbed").select_option("1")
        rest(seen)
        page.locator(".mode").first.click()  # its components by the names of the states
        rest(seen)
        said = page.locator(".outcome").inner_text()
        names = re.findall(r"(\w+) [\d.]+ \(", said.partition("Sizes and phases: ")[2])
        assert names and set(names) <= set(towed_wheel().system.states)
        page.get_by_role("button", name="Python").click()
        assert "st.spectrum(family, at=" in page.locator("pre").inner_text()
        quiet(seen)


def test_the_widget_is_the_same_page(browser: Any, tmp_path: Path) -> None:
    made = st.explore("rolling", contact="rough", certify=False)
    page_file = tmp_path / "notebook.html"
    page_file.write_text(
        "<!DOCTYPE html><meta charset=utf-8><div id=cell></div><script type=module>"
        f"const text = {json.dumps(made._esm).replace('<', chr(92) + 'u003c')};"
        "const blob = new Blob([text], {type: 'text/javascript'});"
        "const module = await import(URL.createObjectURL(blob));"
        "window.remove = module.default.render({el: document.getElementById('cell')});</script>",
        encoding="utf-8",
    )
    with visit(browser, page_file) as seen:
        assert "rolling" in seen.page.locator("h1").inner_text().lower()
        assert seen.page.locator(".mode").count() >= 1
        assert seen.page.get_by_role("button", name="Python").count() == 1
        assert seen.page.get_by_role("button", name="Link").count() == 0  # a cell has no address
        seen.page.evaluate("window.remove()")
        assert not seen.page.locator(".explorer").count()
        quiet(seen)


@pytest.mark.parametrize("link", ["#at=%E0%A4%A&k=0.3", "#%=1&k=0.3", "#k=0.3&mu=%zz"])
def test_a_link_that_is_damaged_restores_the_rest(
    browser: Any, page_of_disk: Path, link: str
) -> None:
    with visit(browser, page_of_disk, link) as seen:
        assert state(seen)["values"]["k"] == 0.3
        quiet(seen)
