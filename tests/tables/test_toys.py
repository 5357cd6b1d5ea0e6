"""Printed values of toys: the recomputed ones by closed forms and by a motion of rotations."""

from functools import cache
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stability.tables import toys
from stability.tables.registry import definition
from stability.tables.table import Standing


@cache
def rows() -> dict[str, dict[str, Any]]:
    table = definition("toys").rows()
    return {row["quantity"]: row for row in table}


def test_one_ball_lifts_at_the_printed_rate() -> None:
    """Balance of moments about the centre: 2/5 Ω² R = g."""
    row = rows()["rate above which one ball lifts"]
    rate = mp.sqrt(mp.mpf("2.5") * mp.mpf("9.81") / mp.mpf("0.008")) / (2 * mp.pi)
    assert row["recomputed"] == pytest.approx(float(rate), rel=1e-14)
    assert row["status"] == "agrees to all digits"


def test_the_inclination_is_that_of_the_printed_formula() -> None:
    [row] = [r for q, r in rows().items() if "cos θ" in q]
    assert row["status"] == "agrees to all digits"
    assert float(row["known"]) == pytest.approx(np.sin(np.radians(10)), abs=1e-13)


def test_the_mass_is_that_of_the_meridian() -> None:
    """The profile integrated by mpmath."""
    R, h, f = mp.mpf("0.03755"), mp.mpf("0.0128"), mp.mpf("0.002")
    edge = mp.quad(lambda z: (R - f + mp.sqrt(f**2 - z**2)) ** 2, [0, f])
    mass = mp.mpf("7792.2775") * mp.pi * (R**2 * (h - 2 * f) + 2 * edge)
    row = rows()["mass"]
    assert abs(row["recomputed"] - mass) <= row["bound"] + mp.mpf("1e-12")
    assert row["status"] == "agrees to all digits"


def test_the_coin_moves_as_by_newton_and_euler() -> None:
    """Angular momentum about the contact, with a rotation matrix, in the frame of the ground."""
    r, g = 0.01, 9.81
    tilt, z = np.radians(1), np.array([0.0, 0.0, 1.0])

    def rates(_: float, y: Any) -> Any:
        a, w = y[:3], y[3:6]
        up = z - a * a[2]
        size = np.sqrt(up @ up)
        arm = -r * up / size  # from the centre to the contact
        da = np.cross(w, a)
        dup = -da * a[2] - a * da[2]
        darm = -r * (dup / size - up * (up @ dup) / size**3)
        moment = 0.25 * r**2 * np.eye(3) + 0.25 * r**2 * np.outer(a, a)
        turn = 0.25 * r**2 * (np.outer(da, a) + np.outer(a, da))
        # centre v = -w × arm; I w' = -turn w + arm × (v' + g z)
        cross = np.array([[0, -arm[2], arm[1]], [arm[2], 0, -arm[0]], [-arm[1], arm[0], 0]])
        known = np.cross(arm, -np.cross(w, darm) + g * z) - turn @ w
        dw = np.linalg.solve(moment - cross @ cross, known)
        return [*da, *dw, *(-np.cross(w, arm))]

    a = np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
    start = [*a, 0.0, 0.0, 10 * np.pi, r * np.sin(tilt), 0.0, r * np.cos(tilt)]
    end = solve_ivp(rates, (0, 0.5), start, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    up = z - end[:3] * end[2]
    contact = end[6:] - r * up / np.sqrt(up @ up)
    assert abs(contact[2]) < 1e-10
    row = rows()["x of the contact at 0.5 s"]
    assert row["recomputed"] == pytest.approx(contact[0], rel=1e-6)
    assert row["status"].startswith("differs: agrees to 3 digits of 10")


def test_what_has_no_value_is_said_and_nothing_is_reproduced() -> None:
    missing = [row for row in rows().values() if row["recomputed"] is None]
    assert [row["known"] for row in missing] == ["words", "7.7459667", "8.9442719"]
    assert all(row["status"].startswith("not covered: the ") for row in missing)
    about = definition("toys").about
    assert about is not None and about.largest is not None
    assert about.standing is Standing.RECOMPUTED
    off = [abs(r["difference"] / float(r["known"])) for r in rows().values() if r["recomputed"]]
    assert about.largest / 5 < max(off) <= about.largest
    assert toys.LEAN == 10
