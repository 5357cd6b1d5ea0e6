"""Spectra and boundaries as CSV, pandas and LaTeX, from Python and from the command line."""

from __future__ import annotations

import io
import re

import numpy as np
import pandas as pd
import pytest
from command_line import output, refused

import stability as st

COIN = ["--disk", "quarter", "--mu", "0.3"]


def table(text: str) -> pd.DataFrame:
    return pd.read_csv(io.StringIO(text))


def test_a_spectrum_is_a_data_frame_with_every_number_and_unit() -> None:
    at, mu = np.array([1.2, 1.8]), np.array([[0.3], [1.0], [3.0]])
    found = st.spectrum("rolling", at=at, contact=st.Viscous(mu))
    frame = found.to_pandas()
    assert list(frame)[:3] == ["omega3 [√(g/R)]", "k", "mu [1/√(gR)]"]
    assert len(frame) == found.eigenvalues.size
    values = frame["real [√(g/R)]"] + 1j * frame["imaginary [√(g/R)]"]
    assert (values.to_numpy() == found.eigenvalues.ravel()).all()
    assert (frame["error [√(g/R)]"].to_numpy() == found.radius.ravel()).all()
    point = frame[(frame["omega3 [√(g/R)]"] == 1.8) & (frame["mu [1/√(gR)]"] == 1.0)]
    own = st.spectrum("rolling", at=1.8, contact=st.Viscous(1.0))
    assert set(point.verdict) == {own.verdict.word} and list(point["mode"]) == list(
        own.modes.labels
    )
    pd.testing.assert_frame_equal(table(found.to_csv()), frame, check_dtype=False)


def test_numbers_in_si_and_of_bodies_and_own_systems_have_columns() -> None:
    coin = st.spectrum("rolling", at=60.0, disk=st.Disk.named("quarter"), contact=st.Rough())
    names = ["omega3 [rad/s]", "k", "mass [kg]", "radius [m]", "gravity [m/s²]"]
    assert list(coin.to_pandas())[:5] == names
    torus = st.spectrum("rolling", at=2.0, body=st.Torus(0.2), contact=st.Viscous(0.3))
    assert list(torus.to_pandas())[:3] == ["omega3 [√(g/R)]", "tube", "mu [1/√(gR)]"]
    circling = st.spectrum("circling", at=[1.2, 2.2], contact=st.Rough())
    assert list(circling.to_pandas())[:2] == ["theta [rad]", "phi_dot [√(g/R)]"]


def test_boundaries_are_a_data_frame() -> None:
    found = st.boundaries("spinning", axis=("at", 0.1, 5, 9), contact=st.Viscous(0.97))
    frame = found.to_pandas()
    assert list(frame["at [√(g/R)]"]) == [b.value for b in found]
    assert list(frame["error [√(g/R)]"]) == [b.error for b in found]
    assert list(frame.crossing) == ["static", "flutter"] and list(frame.side) == ["above", "below"]
    none = st.boundaries("spinning", axis=("at", 3, 5, 9), contact=st.Viscous(0.97))
    assert none.to_pandas().empty and list(none.to_pandas()) == list(frame)


def test_the_command_prints_csv(capsys: pytest.CaptureFixture[str]) -> None:
    frame = table(output(capsys, "spectrum", "rolling", "--at", "60", *COIN, "--csv"))
    own = st.spectrum("rolling", at=60.0, disk=st.Disk.named("quarter"), contact=st.Viscous(0.3))
    assert list(frame["real [1/s]"]) == list(own.eigenvalues.real)
    assert set(frame["mu [s/m]"]) == {0.3} and set(frame["omega3 [rad/s]"]) == {60}
    edges = table(output(capsys, "boundaries", "rolling", "--axis", "at:1:90:9", *COIN, "--csv"))
    [edge] = st.boundaries(
        "rolling",
        axis=("at", 1, 90, 9),
        disk=st.Disk.named("quarter"),
        contact=st.Viscous(0.3),
    )
    assert list(edges["omega3 [rad/s]"]) == [edge.value]
    assert list(edges["frequency [1/s]"]) == [edge.frequency]
    assert set(edges["gravity [m/s²]"]) == {9.81}


@pytest.mark.parametrize(
    ("words", "rows"),
    [
        (["spectrum", "rolling", "--at", "1.8", "--mu", "0.3"], 4),
        (["spectrum", "rolling", "--at", "60", *COIN], 4),
        (["boundaries", "spinning", "--axis", "at:0.1:5:9", "--mu", "0.97"], 2),
        (["boundaries", "spinning", "--axis", "at:3:5:9", "--mu", "0.97"], 0),
    ],
)
def test_the_command_prints_latex(
    capsys: pytest.CaptureFixture[str], words: list[str], rows: int
) -> None:
    text = output(capsys, *words, "--latex")
    body = text.split(r"\midrule")[1].split(r"\bottomrule")[0]
    assert body.count(r"\\") == rows
    assert text.startswith(f"% stability {words[0]}\n") and r"\toprule" in text
    assert not re.search(r"\d1/", text.split(r"\label")[0])  # 0.3 1/√(gR) is not 0.31/√(gR)
    if not rows:
        assert "no boundary, unstable throughout" in text


def test_a_caption_says_the_proof_and_keeps_units_out_of_formulas(
    capsys: pytest.CaptureFixture[str],
) -> None:
    words = ["spectrum", "spinning", "--disk", "quarter", "--at", "62.8", "--mu", "1"]
    text = output(capsys, *words, "--certify", "--latex").split(r"\label")[0]
    assert r"radius $=0.01213$ m, $k=0.25$, gravity $=9.81$ m/s$^{2}$, $\mu =1$ s/m: stable" in text
    assert "proved in rational arithmetic" in text


@pytest.mark.parametrize("command", [["spectrum", "rolling", "--at", "1.8"],
                                     ["boundaries", "rolling", "--axis", "at:1:2:9"]])  # fmt: skip
def test_two_forms_of_one_answer_are_refused(
    capsys: pytest.CaptureFixture[str], command: list[str]
) -> None:
    assert "--csv and --latex are both given" in refused(
        capsys, *command, "--mu", "1", "--csv", "--latex"
    )
