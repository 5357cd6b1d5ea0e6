"""A launch that ends its worker: its number is said, and the others have their ends."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray

import stability as st
from stability.basin.dataset import told_of_lost
from stability.motion.result import Outcome

LAUNCHES = {
    "contact": "viscous",
    "mu": 0.3,
    "family": "spinning",
    "horizon": 5.0,
    "check": False,
    "x": ("phi_dot", 2.0, 3.0, 4),
    "y": ("tilt", 0.1, 0.4, 3),
}
SCRIPT = """
import json, multiprocessing, os, signal, warnings
import numpy as np
import stability as st
from stability.basin import basins as module

def deadly(launches, judging):
    start = np.abs(launches.starts[:, [0, 2]] - [np.pi / 2 - 0.25, 7 / 3]).max(axis=1)
    if multiprocessing.parent_process() and (start < 0.01).any():
        os.kill(os.getpid(), signal.SIGKILL)
    return outcomes(launches, judging)

outcomes, module.outcomes = module.outcomes, deadly
if __name__ == "__main__":
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = st.basins(**json.loads(os.environ["LAUNCHES"]), store="a.zarr", chunk=2,
                          executor="processes", workers=1)
    print(json.dumps([found.attrs["lost"], [str(w.message) for w in told]]))
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="signals of Linux")
def test_a_launch_that_ends_its_worker_is_said_and_the_others_end(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "script.py").write_text(SCRIPT)
    environment = dict(os.environ) | {"LAUNCHES": json.dumps(LAUNCHES)}
    ran = subprocess.run(
        [sys.executable, "script.py"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    numbers, told = json.loads(ran.stdout)
    assert numbers == [5]  # the second of four in the second row
    assert told == ["launch 5 ended its worker and is unresolved."]
    found, whole = xarray.open_zarr(tmp_path / "a.zarr"), st.basins(**LAUNCHES)  # type: ignore[arg-type]
    lost = np.zeros((3, 4), dtype=bool)
    lost[1, 1] = True
    assert (found.outcome.values[lost] == Outcome.UNRESOLVED.code).all()
    assert np.isnan(found.start_state.values[lost]).all()
    for name in ("outcome", "end_time", "start_state"):
        np.testing.assert_array_equal(found[name].values[~lost], whole[name].values[~lost])
    assert "lost" not in whole.attrs
    # the command says them too, of a store that an earlier run filled
    with pytest.warns(st.StabilityWarning, match="launch 5 ended"):
        again = st.basins(**LAUNCHES, store=tmp_path / "a.zarr", chunk=2)  # type: ignore[arg-type]
    assert again.attrs["lost"] == [5]
    from stability.cli.commands import main

    words = [
        "basins",
        "--family",
        "spinning",
        "--mu",
        "0.3",
        "--x",
        "phi_dot:2:3:4",
        "--y",
        "tilt:0.1:0.4:3",
        "--time",
        "5",
        "--no-check",
        "--chunk",
        "2",
        "--out",
        str(tmp_path / "a.zarr"),
    ]
    assert main(words) == 0
    assert "; launch 5 ended its worker and is unresolved" in capsys.readouterr().out
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["lost"] == [5]


def test_many_lost_launches_are_named_in_part() -> None:
    assert told_of_lost(()) == ""
    assert told_of_lost(tuple(range(7))) == (
        "launches 0, 1, 2, 3, 4 and 2 more ended their workers and are unresolved"
    )
