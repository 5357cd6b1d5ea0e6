"""Maps of launches under resistance, against one launch at a time, and their stores."""

from pathlib import Path
from typing import Any

import pytest

import stability as st

AXES: dict[str, Any] = {
    "x": ("phi_dot", 0.5, 2.0, 3),
    "y": ("theta", 0.4, 1.2, 2),
    "horizon": 20.0,
}


def test_each_launch_of_a_map_ends_as_simulate_says(tmp_path: Path) -> None:
    resistance = [st.RollingResistance(0.2), st.AirTorque(0.05)]
    store = tmp_path / "resisted.zarr"
    basins = st.basins(contact=st.Rough(), resistance=resistance, store=store, **AXES)
    words = basins.outcome.attrs["flag_meanings"].split()
    codes = list(basins.outcome.attrs["flag_values"])
    for at in basins.phi_dot.values:
        for theta in basins.theta.values:
            run = st.simulate(
                contact=st.Rough(),
                start={"theta": theta, "phi_dot": at},
                times=20.0,
                resistance=resistance,
            )
            end = basins.sel(phi_dot=at, theta=theta)
            assert words[codes.index(int(end.outcome))].replace("_", "-") == run.attrs["outcome"]
            assert float(end.end_time) == pytest.approx(float(run.end_time), abs=1e-5)
    assert "flat" in {words[codes.index(v)] for v in basins.outcome.values.ravel()}
    with pytest.raises(st.StabilityError, match="other"):
        st.basins(contact=st.Rough(), resistance=st.AirTorque(0.05), store=store, **AXES)


def test_resistance_of_a_map_is_one_number_each() -> None:
    with pytest.raises(st.StabilityError, match="rho"):
        st.basins(contact=st.Rough(), resistance=st.RollingResistance([0.1, 0.2]), **AXES)
