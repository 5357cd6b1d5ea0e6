"""SI units on the page of a coin: numbers, axes, launch, typing, switch, link and exports."""

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from chromium import Visit, visit
from page_numbers import COIN, RATE, REST, SAME, apart, eigenvalues

import stability as st


@pytest.fixture
def coin(browser: Any, page_of_coin: Path) -> Iterator[Visit]:
    with visit(browser, page_of_coin, accept_downloads=True) as found:
        yield found
        assert not found.said and not found.asked


def called(page: Any) -> dict[str, Any]:
    """What the Python calls of the page give."""
    page.evaluate(REST)
    page.evaluate(
        "stabilityExplorer.exports.python.hidden = false; stabilityExplorer.exports.fill()"
    )
    code = page.locator("pre").inner_text()
    space: dict[str, Any] = {"code": code}
    exec(re.sub(r", (?:300|200)((?:, \"log\")?\))", r", 3\1", code), space)  # noqa: S102
    return space


def test_the_numbers_that_were_given_are_shown_with_their_units(coin: Visit) -> None:
    page = coin.page
    page.evaluate(REST)
    shown = [page.locator(".slider input[type=number]").nth(i).input_value() for i in range(2)]
    assert [float(v) for v in shown] == [45.0, 0.9]
    words = page.locator(".sliders").inner_text()
    assert "rad/s" in words and "s/m" in words
    known = st.spectrum("rolling", at=45.0, disk=COIN, contact=st.Viscous(0.9))
    said = page.locator(".lambda").all_inner_texts()
    for text in said:
        number = float(text.split("±")[0].replace("−", "-"))
        assert np.abs(known.eigenvalues.real - number).min() < 1e-3 * abs(number)
    low, high = page.evaluate("stabilityExplorer.view.state.ranges.at")
    assert (low * RATE, high * RATE) == pytest.approx((5.0, 100.0), rel=1e-12)
    assert "R = 0.01213 m" in page.locator(".units").inner_text()


def test_the_ticks_of_an_axis_stand_at_their_values(coin: Visit) -> None:
    """The boundary 2kω₃² = g/R stands between the ticks where the hand would draw it."""
    page = coin.page
    page.evaluate(REST)
    ticks = page.evaluate(
        "[...document.querySelectorAll('.over .number[text-anchor=middle]')]"
        ".map((e) => [Number(e.textContent), Number(e.getAttribute('x'))])"
    )
    values, places = np.array(ticks).T
    slope, start = np.polyfit(values, places, 1)
    first = page.locator("path.boundary").first.get_attribute("d")
    place = float(first.removeprefix("M").split("L")[0].split()[0])
    assert (place - start) / slope == pytest.approx(RATE / math.sqrt(0.5), abs=0.05)
    titles = "".join(page.locator(".over .title, .bar .title").all_text_contents())
    assert "[rad/s]" in titles and "[s/m]" in titles and "[1/s]" in titles


def test_a_launch_is_told_in_seconds_joules_and_newtons(coin: Visit) -> None:
    page = coin.page
    page.evaluate("stabilityExplorer.view.move({at: 1.4066})")
    space = called(page)
    run = space["motion"]
    assert run.attrs["outcome"] == "lift-off"
    said = page.locator(".outcome").inner_text()
    ended = float(re.search(r"at t = ([\d.]+) s ", said)[1])
    assert ended == pytest.approx(float(run.end_time), rel=1e-4)
    traces = page.locator(".traces").text_content()
    assert "energy [J]" in traces and "normal force [N]" in traces and "time t [s]" in traces
    highest = float(page.locator(".traces .number").nth(1).text_content())
    assert highest == pytest.approx(float(run.energy.max()), rel=3e-3)


def test_a_number_is_typed_in_the_unit_that_is_shown(coin: Visit) -> None:
    page = coin.page
    number = page.get_by_label("axial angular velocity ω₃, number")
    number.fill("60")
    number.press("Enter")
    assert page.evaluate("stabilityExplorer.view.state.values.at") * RATE == pytest.approx(60.0)
    page.get_by_text("Axes", exact=True).click()
    upper = page.get_by_label("axial angular velocity ω₃, upper end of the axis")
    upper.fill("80")
    upper.press("Enter")
    assert page.evaluate("stabilityExplorer.view.state.ranges.at[1]") * RATE == pytest.approx(80.0)


def test_the_switch_is_kept_by_link_picture_and_call(
    browser: Any, page_of_coin: Path, coin: Visit
) -> None:
    page = coin.page

    def words_of_picture() -> str:
        with page.expect_download() as waiting:
            page.get_by_role("button", name="SVG").click()
        tree = ElementTree.fromstring(Path(waiting.value.path()).read_text(encoding="utf-8"))
        return "".join(tree.itertext())

    page.evaluate(REST)
    assert "[rad/s]" in words_of_picture()
    page.get_by_role("radio", name="Dimensionless").click()
    page.evaluate(REST)
    assert "[√(g/R)]" in words_of_picture()
    space = called(page)
    assert "mass=" not in space["code"]
    assert apart(eigenvalues(page), np.asarray(space["point"].eigenvalues)) < SAME
    page.wait_for_timeout(400)
    kept, link = page.evaluate("stabilityExplorer.view.state"), page.evaluate("location.hash")
    assert "units=dimensionless" in link and not kept["si"]
    with visit(browser, page_of_coin, link) as seen:
        assert seen.page.evaluate("stabilityExplorer.view.state") == kept


def test_a_page_without_mass_and_length_has_no_switch(opened_disk: Visit) -> None:
    assert opened_disk.page.locator(".units").is_hidden()
    assert not opened_disk.page.evaluate("stabilityExplorer.view.state.si")
