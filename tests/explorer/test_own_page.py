"""The page of a user's own family in Chromium: modes played, sizes, phases, steady values."""

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from chromium import DESKTOP, PHONE, Visit, visit
from own_families import CASES, SHOWN, agrees, number, vector_of
from own_systems import system_of
from page_numbers import REST

import stability as st

SAME = 1e-6
"""Largest difference of a curve from Python's, over the amplitude."""
ROW, TOP, TALL = 62, 15, 41
"""Pixels of a curve: height of its row, its upper end there, its own height."""


def made(name: str, folder: Path) -> Path:
    make, given = CASES[name]
    path: Path = st.explore(make(), certify=False, out=folder / f"{name}.html", **given)
    return path


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("own")
    return {name: made(name, folder) for name in CASES}


@pytest.fixture(params=CASES)
def own(
    request: Any, browser: Any, pages: dict[str, Path]
) -> Iterator[tuple[Visit, st.Family, st.Spectrum]]:
    make, given = CASES[request.param]
    family = make()
    with visit(browser, pages[request.param]) as seen:
        seen.page.evaluate(REST)
        yield seen, family, st.spectrum(family, **given)
        assert not seen.said and not seen.asked


def choose(seen: Visit, index: int) -> dict[str, Any]:
    """Click a mode; what is shown then."""
    seen.page.locator(".mode").nth(index).click()
    seen.page.evaluate(REST)
    found: dict[str, Any] = seen.page.evaluate(SHOWN)
    assert found["kind"] == "mode"
    return found


def test_curves_of_a_mode_are_those_of_pythons_eigenvectors(
    own: tuple[Visit, st.Family, st.Spectrum],
) -> None:
    seen, family, known = own
    seen.page.evaluate("stabilityExplorer.view.set({tilt: 0.25})")
    count = seen.page.locator(".mode").count()
    assert count == np.count_nonzero(known.eigenvalues.imag >= 0)
    for index in range(count):
        found = choose(seen, index)
        value = complex(*found["eigenvalue"])
        vector, steady = vector_of(known, value), np.asarray(known.states).reshape(-1)
        times, states = np.array(found["times"]), np.array(found["states"])
        assert len(states) == len(family.system.states) and times[0] == 0
        for at in (0, 137, len(times) - 1):
            true = steady + 0.25 * (vector * np.exp(value * times[at])).real
            reach = 0.25 * max(1.0, abs(np.exp(value * times[at])))
            assert states[:, at] == pytest.approx(true, abs=SAME * reach)
        # a few periods, or e-folding times
        period = 2 * math.pi / abs(value.imag) if value.imag else math.inf
        assert found["until"] == pytest.approx(min(3 * period, 6 / abs(value.real)), rel=1e-9)
        drawn_as_computed(seen, times, states)
        said = seen.page.locator(".outcome").inner_text()
        assert said.startswith(f"Mode {index + 1} of the linear motion (float)")
        factor = math.exp(value.real * found["until"])
        shown = re.search(r"multiplied by ([^ ]+)\. Sizes", said)
        assert number(shown[1]) == pytest.approx(factor, rel=6e-3) if shown else "stays" in said
        caption = seen.page.locator(".caption").inner_text()
        assert "Linear motion" in caption and "float" in caption


def drawn_as_computed(seen: Visit, times: np.ndarray, states: np.ndarray) -> None:
    """The curves on the page lie where the numbers at their ends say."""
    paths = [seen.page.locator(".trace").nth(j).get_attribute("d") for j in range(len(states))]
    for row, (path, values) in enumerate(zip(paths, states, strict=True)):
        x, y = np.array([p.split() for p in path.removeprefix("M").split("L")], float).T
        low, high = values.min(), values.max()
        if low == high:
            assert np.ptp(y) == 0
            continue
        places = np.interp((x - x[0]) / (x[-1] - x[0]), times / times[-1], values)
        bottom = row * ROW + TOP + TALL
        assert low + (bottom - y) / TALL * (high - low) == pytest.approx(
            places, abs=0.02 * (high - low)
        )


def test_sizes_and_phases_are_pythons(own: tuple[Visit, st.Family, st.Spectrum]) -> None:
    seen, family, known = own
    for index in range(seen.page.locator(".mode").count()):
        found = choose(seen, index)
        vector = vector_of(known, complex(*found["eigenvalue"]))
        rows = seen.page.locator(".states tbody tr")
        assert f"mode {index + 1}" in seen.page.locator(".states").inner_text()
        for j, name in enumerate(family.system.states):
            cells = rows.nth(j).locator("th, td").all_inner_texts()
            assert cells[0] == name
            agrees(cells[2], cells[3], vector[j])
        said = seen.page.locator(".outcome").inner_text().partition("Sizes and phases: ")[2]
        parts = re.findall(r"(\w+) ([^ ]+) \(([^)]+)\)", said)
        assert parts[0][1:] == ("1", "0°")
        assert {n for n, *_ in parts} == {
            n for n, v in zip(family.system.states, vector, strict=True) if abs(v) > 1e-9
        }
        for name, size, phase in parts:
            agrees(size, phase, vector[family.system.states.index(name)])


def test_every_state_has_its_steady_value_and_unit(
    own: tuple[Visit, st.Family, st.Spectrum],
) -> None:
    seen, family, known = own
    steady, units = np.asarray(known.states).reshape(-1), family.system.units
    rows = seen.page.locator(".states tbody tr")
    assert rows.count() == len(family.system.states)
    assert "float" in seen.page.locator(".states caption").inner_text()
    for j, name in enumerate(family.system.states):
        said = rows.nth(j).locator("td").first.inner_text()
        value, _, unit = said.removeprefix("= ").partition(" ")
        assert number(value) == pytest.approx(steady[j], rel=6e-6, abs=1e-12)
        assert unit == units.get(name, "")
    seen.page.get_by_role("radio", name="Steady").click()
    seen.page.evaluate(REST)
    found = seen.page.evaluate(SHOWN)
    assert found["kind"] == "steady"
    assert np.array(found["states"])[:, [0, -1]].T == pytest.approx(
        np.array([steady, steady]), abs=1e-11
    )
    assert "steady motion" in seen.page.locator(".caption").inner_text()


def test_only_an_observable_named_energy_has_a_curve_of_the_energy(
    own: tuple[Visit, st.Family, st.Spectrum],
) -> None:
    seen, family, _ = own
    seen.page.get_by_role("radio", name="Launch").click()
    seen.page.evaluate(REST)
    found = seen.page.evaluate(SHOWN)
    assert found["names"][: len(family.system.states)] == list(family.system.states)
    has = "energy" in family.system.observables
    assert ("energy" in found["names"]) == has
    traces = seen.page.locator(".traces").text_content()
    assert ("energy" in traces) == has
    if "energy" in family.system.units:
        assert "energy [J/kg]" in traces and "height [m]" in traces and "time t [s]" in traces
    if not has:
        return
    run = seen.page.evaluate("({...stabilityExplorer.motion.traces.run.series})")
    x, p = family.system.x, family.system.p
    energy = ca.Function("energy", [x, p], [family.system.observables["energy"]])
    values = seen.page.evaluate("stabilityExplorer.view.state.values")
    given = [values[n] for n in family.system.parameters]
    for at in (0, 400):
        state = [run[n][at] for n in family.system.states]
        assert run["energy"][at] == pytest.approx(float(energy(state, given)), rel=1e-9, abs=1e-12)


def test_hand_and_keys_reach_every_picture(browser: Any, pages: dict[str, Path]) -> None:
    with visit(browser, pages["wheel"]) as seen:
        page = seen.page

        def state() -> dict[str, Any]:
            page.evaluate(REST)
            found: dict[str, Any] = page.evaluate("stabilityExplorer.view.state")
            return found

        assert not page.locator(".motion-stage").is_visible()
        page.get_by_role("radio", name="Launch").focus()
        for key, name in (
            ("ArrowLeft", "mode"),
            ("ArrowLeft", "steady"),
            ("ArrowLeft", "launch"),
            ("ArrowRight", "steady"),
            ("ArrowRight", "mode"),
        ):
            page.keyboard.press(key)
            assert state()["show"] == name
            chosen = page.locator(".motion .segments [aria-checked=true]")
            assert chosen.inner_text().lower() == name
            assert page.evaluate("document.activeElement.dataset.name") == name
        # of a mode the slider is the amplitude, and its curves follow
        before = page.evaluate(SHOWN)["states"][0]
        assert not page.get_by_label("Length of the run").is_visible()
        assert not page.get_by_label("State that is disturbed").is_visible()
        page.get_by_label("Amplitude of the mode").focus()
        for _ in range(40):
            page.keyboard.press("ArrowRight")
        assert state()["show"] == "mode" and state()["tilt"] > 0.1
        assert max(page.evaluate(SHOWN)["states"][0]) > max(before)
        # the arrows of the list of modes choose another one
        page.locator(".mode").first.focus()
        page.keyboard.press("ArrowDown")
        assert state()["mode"] == 1
        assert page.locator(".outcome").inner_text().startswith("Mode 2")
        page.get_by_label("Time", exact=True).evaluate(
            "(e) => { e.value = 500; e.dispatchEvent(new Event('input')); }"
        )
        page.evaluate(REST)
        half = page.evaluate(SHOWN)["until"] / 2
        said = page.locator(".motion .clock").first.inner_text()
        assert float(said.removeprefix("t = ").removesuffix(" s")) == pytest.approx(half, rel=0.01)
        cursor = page.locator(".traces .cursor").get_attribute("d")
        assert float(cursor[1:].split()[0]) > 200
        page.locator(".traces").click(position={"x": 70, "y": 30})
        page.evaluate(REST)
        assert page.evaluate("stabilityExplorer.motion.time") < half
        page.wait_for_timeout(400)
        kept, link = state(), page.evaluate("location.hash")
        page.get_by_role("radio", name="Steady").click()
        assert state()["show"] == "steady"
        assert not page.get_by_label("Size of the disturbance").is_visible()
        page.get_by_role("radio", name="Launch").click()
        state()
        page.get_by_label("State that is disturbed").focus()
        page.keyboard.press("ArrowDown")
        assert state()["kick"] == 1
        label = page.evaluate("document.activeElement.getAttribute('aria-label')")
        assert label == "State that is disturbed"  # the focus stays
        assert not seen.said and not seen.asked
    with visit(browser, pages["wheel"], link) as seen:
        seen.page.evaluate(REST)
        assert seen.page.evaluate("stabilityExplorer.view.state") == kept
        assert seen.page.evaluate(SHOWN)["kind"] == "mode"


@pytest.mark.parametrize("picture", ["mode", "launch", "steady"])
def test_curves_are_played_unless_motion_is_unwanted(
    browser: Any, pages: dict[str, Path], picture: str
) -> None:
    for wish in ("reduce", "no-preference"):
        link = f"#picture={picture}"
        with visit(browser, pages["governor"], link, reduced_motion=wish) as seen:
            page = seen.page
            page.locator(".traces").scroll_into_view_if_needed()
            page.wait_for_timeout(500)
            moved = page.evaluate("stabilityExplorer.motion.time") > 0
            assert moved == (wish == "no-preference")
            if wish == "reduce":
                page.get_by_label("Play or pause").click()
                page.wait_for_timeout(400)
                assert page.evaluate("stabilityExplorer.motion.time") > 0
            page.get_by_label("Play or pause").click()
            assert not page.evaluate("stabilityExplorer.motion.playing")
            assert not seen.said


@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=["desktop", "phone"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_fits_the_screen_and_its_text_can_be_read(
    browser: Any, pages: dict[str, Path], size: dict[str, int], scheme: str
) -> None:
    assert pages["wheel"].stat().st_size < 1_500_000
    for picture in ("mode", "launch", "steady"):
        with visit(
            browser, pages["wheel"], f"#picture={picture}", size=size, color_scheme=scheme
        ) as seen:
            page = seen.page
            page.evaluate(REST)
            assert page.evaluate("document.documentElement.scrollWidth") <= size["width"]
            small = page.evaluate(
                "[...document.querySelectorAll('button, select, input')]"
                ".filter((e) => e.getClientRects().length && e.getBoundingClientRect().height < 24)"
                ".map((e) => e.outerHTML.slice(0, 80))"
            )
            assert not small
            ink, paper = page.evaluate(
                "['.states td', '.explorer'].map((s, i) => Number(getComputedStyle("
                "document.querySelector(s))[i ? 'backgroundColor' : 'color'].match(/\\d+/)[0]))"
            )
            assert (ink > 200 and paper < 60) if scheme == "dark" else (ink < 60 and paper > 200)
            assert not seen.said


def test_a_place_without_a_member_has_no_table_and_no_mode(browser: Any, tmp_path: Path) -> None:
    x, y, p, c = (ca.SX.sym(n) for n in ("x", "y", "p", "c"))
    system = system_of("fold", [x, y], [p, c], [y, p + c * x - x**2 - y])
    near = {"x": 1.5, "p": 2.0, "c": 0.2}
    upper = system.steady("p", held={"y": 0.0}, guess=near, equations=("y",), name="upper")
    path = st.explore(
        upper, at=2.0, c=0.2, x=("p", -1.0, 4.0), certify=False, out=tmp_path / "fold.html"
    )
    with visit(browser, path, "#picture=mode&p=-0.5&c=0.2") as seen:
        page = seen.page
        page.evaluate(REST)
        assert not page.locator(".states").is_visible()
        assert "no member" in page.locator(".outcome").inner_text()
        page.evaluate("stabilityExplorer.view.move({p: 2})")
        page.evaluate(REST)
        assert page.locator(".states").is_visible()
        assert page.locator(".outcome").inner_text().startswith("Mode 1")
        assert not seen.said
