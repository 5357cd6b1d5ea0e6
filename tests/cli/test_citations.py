"""Each object that a command prints says what to cite, and a user's system cites no disk."""

import json
from pathlib import Path

import pytest
from command_line import output

import stability as st
from stability.base.citation import WORKS

DISK = ["stability", "przybylska2016", "casadi"]
SCENE = """
[contact]
law = "viscous"
mu = 0.3
[start]
theta = 1.3
omega3 = 2.0
[question]
horizon = 1.0
"""
COMMANDS = {
    "spectrum rolling --at 1.8 --mu 0.97": [*DISK, "lapack"],
    "spectrum rolling --at 1.8 --mu 0.97 --body torus --tube 0.3": [*DISK, "lapack"],
    "boundaries spinning --axis at:0.1:5:9 --mu 0.97": [*DISK, "arb"],
    "map spinning --x at:1:3:5 --y mu:0.1:1:4 --out {folder}/a.nc": [*DISK, "arb"],
    "map spinning --x at:1:3:5 --y mu:0.1:1:4 --verdict-only --out {folder}/a.zarr": [*DISK, "arb"],
    "simulate --theta 1.3 --omega3 2 --mu 0.3 --time 0.5 --method dop853": [
        *DISK,
        "scipy",
        "hairer1993",
    ],
    "basins --x theta:1.2:1.5:2 --y omega3:1:2:2 --mu 0.3 --time 1 --out {folder}/a.zarr": DISK,
    "scene {folder}/a.toml": DISK,
    "table hopf --k 0.5 --mu 1": [*DISK[:2], "fiedler2000", "casadi", "arb"],
}
"""Words of a command: works that it cites among others."""


@pytest.mark.few(4)
@pytest.mark.parametrize("words", COMMANDS)
def test_the_object_of_a_command_says_what_to_cite(
    words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.toml").write_text(SCENE, encoding="utf-8")
    printed = output(capsys, *(w.format(folder=tmp_path) for w in words.split()), "--json")
    found = json.loads(printed)["citation"].split(", ")
    assert set(found) <= set(WORKS)
    assert [key for key in found if key in COMMANDS[words]] == COMMANDS[words]
    assert ("przybylska2016" in found) is ("przybylska2016" in COMMANDS[words])
    assert st.citation().works[0].key == found[0]
