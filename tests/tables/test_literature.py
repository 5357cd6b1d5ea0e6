"""Tables of the literature, and the list of tables: second routes, and what may be called what."""

import json
import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from kane_disk import kane
from scipy.optimize import brentq

import stability as st
from stability.cli.commands import main
from stability.tables.benchmarks.catalogue import CASES
from stability.tables.benchmarks.row import AGREES, CLOSED, PUBLISHED, QUOTED
from stability.tables.contents.listing import listed
from stability.tables.contents.places import PLACES, definition
from stability.tables.formats.about import Standing
from stability.tables.literature.circular import CIRCLES, LEANS
from stability.tables.literature.flat_laws import LAWS, rim_disk
from stability.tables.literature.flatness import _row, measured

KNOWN = ("circular", "thresholds")
"""Tables of known values that the suite computes."""


@cache
def rows(name: str) -> dict[str, dict[str, Any]]:
    return {row["quantity"]: row for row in st.table(name)}


# --- the list ---


def test_every_table_says_where_it_is_from() -> None:
    said = {row["name"]: row for row in listed()}
    assert set(said) == {*PLACES, "codimension"} - {"list"}
    for row in said.values():
        assert all(
            len(row[key]) >= 8 for key in ("source", "published", "recomputed", "difference")
        )
        assert Standing(row["status"].split(":")[0])


@pytest.mark.parametrize("name", KNOWN)
def test_nothing_is_reproduced_whose_printed_value_was_not_at_hand(name: str) -> None:
    """The standing follows from the rows: published ones, and others."""
    origins = {row["origin"] for row in rows(name).values()}
    by_origin = {
        frozenset({PUBLISHED}): Standing.REPRODUCED,
        frozenset({PUBLISHED, CLOSED}): Standing.PARTLY,
        frozenset({QUOTED, CLOSED}): Standing.RECOMPUTED,
        frozenset({CLOSED}): Standing.RECOMPUTED,
    }
    about = definition(name).about
    assert about is not None
    assert about.standing is by_origin[frozenset(origins)]


def test_no_table_without_published_rows_is_called_reproduced() -> None:
    for name in PLACES:
        about = definition(name).about
        if name not in ("list", "benchmarks", "thresholds"):
            assert about is not None
            assert about.standing in (Standing.RECOMPUTED, Standing.DERIVED), name


def largest(table: Any) -> float:
    """The largest difference relative to the known value."""
    return max(abs(r["difference"] / float(r["known"])) for r in table if float(r["known"]))


@pytest.mark.parametrize("name", KNOWN)
def test_the_stated_difference_is_the_largest(name: str) -> None:
    about = definition(name).about
    assert about is not None and about.largest is not None
    assert about.largest / 5 < largest(rows(name).values()) <= about.largest


@pytest.mark.long
def test_the_stated_difference_of_the_benchmarks_is_the_largest() -> None:
    about = definition("benchmarks").about
    assert about is not None and about.largest is not None
    found = [row for row in st.table("benchmarks", systems=list(CASES)) if row["recomputed"]]
    assert about.largest / 5 < largest(found) <= about.largest
    assert {row["origin"] for row in found} > {PUBLISHED, CLOSED}
    assert about.standing is Standing.PARTLY


def test_the_command_lists_the_tables(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["table", "--list", "--json"]) == 0
    body = json.loads(capsys.readouterr().out)
    names = [column["name"] for column in body["columns"]]
    assert names[2:] == ["source", "published", "recomputed", "difference", "status"]
    assert [row["name"] for row in body["rows"]] == [row["name"] for row in st.table("list")]
    assert main(["table", "--list"]) == 0
    text = capsys.readouterr().out
    assert main(["table", "list"]) == 0
    assert capsys.readouterr().out == text
    assert "reproduced in part: " in text


@pytest.mark.parametrize("words", [[], ["drift", "--list"]])
def test_a_name_or_the_list_is_asked_for(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["table", *words]) == 2
    assert "give the name of a table, or --list" in capsys.readouterr().err


# --- circular rolling: another formulation, another arithmetic ---


def slopes(x: list[float], k: float) -> np.ndarray:
    """Jacobian of SymPy's Kane equations of the rough disk by central differences of rates."""
    step = 1e-5

    def rates(state: np.ndarray) -> np.ndarray:
        six = np.concatenate([state, np.zeros((*state.shape[:-1], 2))], axis=-1)
        return kane("rough", six, np.broadcast_to([k, 0.0], (*state.shape[:-1], 2))).rates[..., :4]

    moved = np.array(x) + step * np.vstack([np.eye(4), -np.eye(4), 2 * np.eye(4), -2 * np.eye(4)])
    one, back, two, far = np.split(rates(moved), 4)
    return np.asarray((8 * (one - back) - (two - far)) / (12 * step)).T


@pytest.mark.parametrize(("lean", "ratio"), CIRCLES)
def test_circles_are_those_of_kanes_method(lean: int, ratio: str) -> None:
    """Spin, precession and nutation, in equations that share no code with the package."""
    k, rate = 0.25, math.sqrt(9.81 / 0.05)
    where = f"lean {lean}°, r/Rc = {ratio}"
    spin = float(rows("circular")[f"relative spin, {where}"]["known"]) / rate
    turn, theta = float(ratio) * spin, math.pi / 2 - math.radians(lean)
    best = min(
        ([theta, 0.0, turn, side * spin + turn * math.cos(theta)] for side in (1, -1)),
        key=lambda x: abs(kane("rough", [*x, 0, 0], [k, 0.0]).rates).max(),
    )
    assert abs(kane("rough", [*best, 0, 0], [k, 0.0]).rates).max() < 1e-13
    values = np.linalg.eigvals(slopes(best, k))
    fast = values[np.argmax(abs(values))]
    [row] = [r for n, r in rows("circular").items() if n.endswith(where) and "certified" in n]
    assert abs(fast) * rate == pytest.approx(float(row["known"]), rel=1e-8)
    assert abs(fast.real) < 1e-6  # neutral, as every circle of the table
    assert "neutral, certified" in row["quantity"]


@pytest.mark.parametrize("lean", LEANS)
def test_unstable_precessions_end_where_kanes_frequency_vanishes(lean: int) -> None:
    k, rate, theta = 0.25, math.sqrt(9.81 / 0.05), math.pi / 2 - math.radians(lean)

    def square(turn: float) -> float:
        """The square of the frequency, from equations of Kane's method."""
        s, c = math.sin(theta), math.cos(theta)
        omega3 = c * (k * turn**2 * s - 1) / ((2 * k + 1) * turn * s)
        matrix = slopes([theta, 0.0, turn, omega3], k)
        return -float(np.trace(matrix @ matrix)) / 2  # two zeros, and a pair

    for word, low, high in (("lower", 0.5, 1.5), ("upper", 0.7, 1.4)):
        row = rows("circular")[f"{word} end of the precessions that are unstable, lean {lean}°"]
        edge = float(row["known"]) / rate
        assert square(low * edge) * square(high * edge) < 0
        found = brentq(square, 0.99 * edge, 1.01 * edge, xtol=1e-10)
        assert found == pytest.approx(edge, rel=1e-7)
        assert {row["below"], row["above"]} == {"neutral", "unstable"}


def test_all_known_values_agree() -> None:
    for name in KNOWN:
        for row in rows(name).values():
            assert row["status"] == AGREES, row


def test_a_wrong_known_value_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """The report's spin with another last digit disagrees."""
    from stability.tables.literature import thresholds

    monkeypatch.setattr(thresholds, "SPIN", "-4.6852")
    assert thresholds._relative_spin().status == "agrees to 4 digits of 5"


# --- the end of a spun disk ---


@pytest.mark.few(1)
@pytest.mark.parametrize("law", [LAWS[2], LAWS[5]], ids=lambda law: law.name)
def test_a_spun_disk_comes_down_as_energy_says(law: Any) -> None:
    row = _row(law, 0.25)
    assert row.simulated == pytest.approx(law.power, abs=3e-3)
    assert row.relative == pytest.approx(0, abs=4e-3)


@pytest.mark.long
@pytest.mark.parametrize("k", [0.25, 0.4])
def test_every_law_brings_the_disk_down_as_energy_says(k: float) -> None:
    table = st.table("flatness", k=k)
    assert [row["law"] for row in table] == [law.name for law in LAWS]
    assert max(abs(row["relative"]) for row in table) < 5e-3
    found = max(abs(row["difference"] / row["formula"]) for row in table)
    about = definition("flatness").about
    assert about is not None and about.largest is not None
    assert found <= about.largest
    assert k != 0.25 or found > about.largest / 5


@pytest.mark.parametrize("power", [3.0, 1.0, -0.5, -2.0])
def test_exponent_and_coefficient_of_an_exact_decay_are_found(power: float) -> None:
    """Closed forms of da/dt = -C a^p, with C = 0.002."""
    p, c = 1 - power, 2e-3
    angle = np.geomspace(0.04, 0.008, 400)
    times = np.log(0.04 / angle) / c if p == 0 else (0.04**p - angle**p) / (p * c)
    assert measured(times, angle, power) == pytest.approx((power, c), rel=1e-7)


def test_a_motion_that_stays_up_is_refused() -> None:
    with pytest.raises(st.StabilityError, match=r"ends at an inclination of 0\.02 rad"):
        measured(np.linspace(0, 1, 9), np.full(9, 0.02), 1.0)


def test_moffatts_time_to_rest_follows_from_the_coefficient() -> None:
    """t_0 = a_0^3 M/(2 pi mu a) for a layer of air of viscosity mu, with M = a = g = 1."""
    viscosity, start, k = 1e-4, 0.1, 0.25
    rate = LAWS[5].coefficient(math.pi * k * viscosity, k)
    left = start ** (1 - LAWS[5].power) / ((1 - LAWS[5].power) * rate)
    assert left == pytest.approx(start**3 / (2 * math.pi * viscosity), rel=1e-14)


def test_the_disk_of_the_table_is_that_of_the_package_without_its_force() -> None:
    """Rates of both at random states, at linear sliding."""
    system = rim_disk(lambda rim, _: -rim)
    rng = np.random.default_rng(1)
    k, sliding = 0.3, 0.7
    for _ in range(5):
        theta, d_theta, d_phi, omega3, sx, sy = rng.uniform(0.3, 1.2, 6)
        rates = st.disk_system("linear-viscous").rates(
            [theta, d_theta, d_phi, omega3, sx, sy], [k, sliding]
        )
        # at phi = 0: x along the radius, y across; slip = velocity of the centre + turn x radius
        d_psi = omega3 - d_phi * math.cos(theta)
        turn = np.array([-d_phi * math.sin(theta), d_theta, omega3])
        lifted = np.array(
            [
                [math.cos(theta), 0, -math.sin(theta)],
                [0, 1, 0],
                [math.sin(theta), 0, math.cos(theta)],
            ]
        )
        arm = np.cross(turn @ lifted, lifted[0])
        state = {
            "phi": 0.0,
            "theta": theta,
            "dx": sx - arm[0],
            "dy": sy - arm[1],
            "dphi": d_phi,
            "dtheta": d_theta,
            "dpsi": d_psi,
        }
        found = dict(
            zip(
                system.states,
                system.rates([state[n] for n in system.states], [k, sliding, 0.0]),
                strict=True,
            )
        )
        assert found["dtheta"] == pytest.approx(rates[1], rel=1e-10)
        assert found["dphi"] == pytest.approx(rates[2], rel=1e-10)
