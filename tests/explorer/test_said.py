"""What the page says, and what stays: numbers over laws, units on pictures, ends of runs."""

from pathlib import Path
from typing import Any

import casadi as ca
import pytest
from chromium import visit
from node import Engine
from page_numbers import REST

import stability as st

COIN = {"mass": 0.0058, "radius": 0.012125, "gravity": 9.81}


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("said") / "coin.html"
    found: Path = st.explore("spinning", disk=st.Disk(**COIN), contact=st.Viscous(0.3), out=out)
    return found


@pytest.fixture
def coin(path: Path) -> Engine:
    return Engine(path)


def test_numbers_are_kept_over_laws_and_families(coin: Engine) -> None:
    shown = (
        "() => { const {view} = stabilityExplorer, q = view.subject.quantity.mu;"
        "return [view.state.values.mu * view.shown(q).size, view.shown(q).unit]; }"
    )
    mu, unit = coin.evaluate(shown)
    assert mu == pytest.approx(0.3, rel=1e-15) and unit == "s/m"
    at = coin.evaluate("stabilityExplorer.view.state.values.at")
    for key in ("spinning smooth", "rolling rough", "tumbling linear-viscous", "spinning viscous"):
        coin.evaluate("(key) => { stabilityExplorer.view.choose(key); }", key)
    assert coin.evaluate(shown) == [mu, unit]
    assert coin.evaluate("stabilityExplorer.view.state.values.at") == at


def test_an_exported_picture_says_mass_radius_and_gravity(coin: Engine, disk: Engine) -> None:
    heading = "stabilityExplorer.exports.heading().join(' ')"
    said = coin.evaluate(heading)
    assert "m = 0.0058 kg, R = 0.012125 m, g = 9.81 m/s²" in said
    assert "k = 0.25" in said and "k = 0.25 m R²" not in said
    coin.evaluate("() => { stabilityExplorer.view.set({si: false}); }")
    for page in (coin, disk):
        assert "dimensionless, m = R = g = 1" in page.evaluate(heading)


def damped() -> st.Family:
    x, v, c, s = (ca.SX.sym(n) for n in "xvcs")
    p, rhs = ca.vertcat(c, s), ca.vertcat(v, -s * x - c * v)
    system = st.System("damped", ca.vertcat(x, v), p, rhs, states=("x", "v"), parameters=("c", "s"))
    return st.Family(system, "rest", at=("c",), held={"x": 0.0, "v": 0.0})


def test_a_run_that_rests_does_not_still_move(coin: Engine, tmp_path: Path) -> None:
    run = (
        "(until) => { const {view, launched} = stabilityExplorer, s = view.subject;"
        "const kick = s.states.map((_, i) => i ? 0 : 0.1);"
        "return launched(s, view.motion, view.point(), kick, until).calm; }"
    )
    own = Engine(st.explore(damped(), at=1.0, s=1.0, certify=False, out=tmp_path / "own.html"))
    assert [own.evaluate(run, until) for until in (2.0, 80.0)] == ["", "steady"]
    coin.evaluate("() => { stabilityExplorer.view.choose('rolling viscous'); }")
    assert coin.evaluate(run, 5.0) == ""


@pytest.mark.browser
def test_a_stable_member_that_drifts_says_so(browser: Any, path: Path) -> None:
    with visit(browser, path, "#show=rolling-viscous&at=3") as seen:
        seen.page.evaluate(REST)
        said = seen.page.locator(".point-panel").inner_text()
        assert "stable" in said and "μ = 0.3 s/m, k = 0.25\n" in said and "rad/s" in said
        assert "Beyond the linear motion it drifts: spectrally stable, yet not Lyapunov" in said
        seen.page.evaluate("() => { stabilityExplorer.view.choose('spinning viscous'); }")
        seen.page.evaluate(REST)
        assert "Beyond" not in seen.page.locator(".point-panel").inner_text()
