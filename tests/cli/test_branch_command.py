"""The command `branch`, against closed forms of a cusp and a pitchfork."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import output, refused

TEXT = """
import casadi as ca, stability as st
x, p, q = (ca.SX.sym(n) for n in "xpq")
rates = ca.vertcat(p, q), q + p * x - x**3
cusp = st.System("cusp", x, *rates, states=("x",), parameters=("p", "q"))
up = cusp.steady("q", guess={"x": -1.5, "q": -1.0}, p=1.0, name="up")
fork = st.System("fork", x, p, p * x - x**3, states=("x",), parameters=("p",))
rest = st.Family(fork, "rest", at=("p",), unknown={"x": 0.0}, equations=("x",))
"""
FOLD = 2 / 27**0.5
"""q at the folds of x³ = x + q, where 3 x² = 1."""


@pytest.fixture
def file(tmp_path: Path) -> str:
    path = tmp_path / "mine.py"
    path.write_text(TEXT)
    return str(path)


def test_folds_are_where_the_cubic_has_a_double_root(
    capsys: pytest.CaptureFixture[str], file: str
) -> None:
    words = ("branch", "--system", f"{file}:up", "--axis", "q:-1:1:51", "--set", "p=1")
    short = json.loads(output(capsys, *words, "--json"))
    assert not short["complete"] and short["ended"].startswith("ended after")
    [fold] = short["folds"]
    assert fold["value"] == pytest.approx(FOLD, rel=1e-12)
    assert fold["states"]["x"] == pytest.approx(-(3**-0.5), rel=1e-7)
    whole = json.loads(output(capsys, *words, "--arclength", "--json"))
    assert whole["complete"]
    assert [f["value"] for f in whole["folds"]] == pytest.approx([FOLD, -FOLD], rel=1e-12)
    assert whole["last"]["states"]["x"] == pytest.approx(1.324717957244746, rel=1e-12)
    text = output(capsys, *words)
    assert text.startswith("cusp, up, along q, at p = 1\n")
    assert "fold" in text and "0.38490017946" in text


def test_a_pitchfork_is_called_one(capsys: pytest.CaptureFixture[str], file: str) -> None:
    text = output(capsys, "branch", "--system", f"{file}:rest", "--axis", "p:-1:1:51")
    assert "pitchfork" in text and "the whole interval from -1 to 1 was reached" in text


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--axis", "p:-1:1:9"), "--axis names p; up is followed along q"),
        (("--axis", "q:-1:1:9:log"), "give no log"),
        (("--axis", "q:-1:1:1", "--set", "p=1"), "points is 1"),
        (("--axis", "q:-1:1:9"), "p is missing"),
    ],
)
def test_what_does_not_fit_is_refused(
    capsys: pytest.CaptureFixture[str], file: str, words: tuple[str, ...], said: str
) -> None:
    assert said in refused(capsys, "branch", "--system", f"{file}:up", *words)
