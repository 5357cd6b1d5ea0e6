"""What the nonlinear motion does, in a file."""

from pathlib import Path

import numpy as np

import stability as st


def test_a_spectrum_that_was_read_back_still_drifts(tmp_path: Path) -> None:
    given = st.spectrum("rolling", at=np.linspace(0.5, 3.0, 12), contact=st.Viscous(0.3))
    again = st.read_map(st.write_map(given.to_xarray(), tmp_path / "rolling.nc"))
    words = again.nonlinear.attrs["flag_meanings"].split()
    sentences = again.nonlinear.attrs["sentences"].split(" | ")
    assert len(words) == len(sentences) == len(st.Nonlinear)
    for code, one in zip(again.nonlinear.values, given.nonlinear, strict=True):
        assert words[code] == one.name.lower() and sentences[code] == one.value
    assert {words[c] for c in again.nonlinear.values} == {"drifts", "unstable"}


def test_one_member_has_one_word() -> None:
    found = st.spectrum("spinning", at=2.5, contact=st.Viscous(0.3)).to_xarray()
    words = found.nonlinear.attrs["flag_meanings"].split()
    assert words[int(found.nonlinear)] == "asymptotic"
