"""Campaigns of minutes for the charts' truths and for the error that a motion states."""

import json
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.bodies.newton_euler import STATES
from stability.compare.motion.chart import distance
from stability.compare.motion.reference_motions import scene
from stability.integrators import taylor
from stability.motion.result import BY_CODE

pytestmark = pytest.mark.long
ROOT = Path(__file__).resolve().parents[2]
NAMES = ("lift-off", "graze-plus-ulp", "near-flat-viscous", "falls-flat", "double-upright")


@pytest.mark.skipif(not taylor.available(), reason="heyoka is an extra")
@pytest.mark.parametrize("name", NAMES)
def test_truths_are_made_again_by_their_script(name: str, tmp_path: Path) -> None:
    out = tmp_path / "truths.json"
    script = ROOT / "benchmarks" / "truths.py"
    subprocess.run(
        [sys.executable, str(script), "--only", name, "--out", str(out)],
        check=True,
        env={"OMP_NUM_THREADS": "1", "PATH": ""},
        capture_output=True,
    )
    [made] = [r for r in json.loads(out.read_text())["scenes"] if r["name"] == name]
    it = scene(name)
    assert made["outcome"] == it.outcome
    assert float(made["end_time"]) == it.end_time
    states = np.array([[float(v) for v in row] for row in made["states"]])
    assert np.array_equal(states, it.states)


def random_launch(rng: np.random.Generator, law: str) -> tuple[Any, Any, list[float], float]:
    mu = float(10 ** rng.uniform(-3, 1))
    contact: Any = {
        "viscous": lambda: st.Viscous(mu),
        "linear-viscous": lambda: st.LinearViscous(mu),
        "smooth": st.Smooth,
        "rough": st.Rough,
        "coulomb": lambda: st.Coulomb(min(mu, 0.5)),
    }[law]()
    start = [
        rng.uniform(0.3, np.pi - 0.3),
        *rng.uniform(-1, 1, 3) * [0.5, 2.0, 2.0],
        *(np.zeros(2) if law == "rough" else rng.uniform(-0.05, 0.05, 2)),
    ]
    return st.Disk(k=rng.uniform(0.1, 0.5)), contact, [float(v) for v in start], 10.0


def test_no_random_launch_states_less_than_its_error() -> None:
    rng = np.random.default_rng(5)
    seen: Counter[str] = Counter()
    worst = 0.0
    for law in ("viscous", "linear-viscous", "smooth", "rough", "coulomb"):
        for _ in range(200):
            disk, contact, start, last = random_launch(rng, law)
            try:
                run = st.simulate(disk, contact, start, [last])
            except st.StabilityError:
                seen["refused"] += 1
                continue
            fine = st.simulate(disk, contact, start, [last], tolerance=1e-15, check=False)
            words = [BY_CODE[int(r.outcome)].word for r in (run, fine)]
            seen[words[0]] += 1
            if "unresolved" in words or words[0] == "undetermined":
                continue
            groups = ["lasts" if w in ("moving", "settled") else w for w in words]
            assert groups[0] == groups[1], (law, contact, start)
            if groups[0] == "lasts":
                ends = [np.array([[float(r[n][-1]) for n in STATES]]) for r in (run, fine)]
                ratio = distance(*ends)[0] / float(run.final_error)
            else:
                late = abs(float(run.end_time) - float(fine.end_time))
                ratio = late / (float(run.end_time_error) + 1e-14)
            worst = max(worst, ratio)
            assert ratio < 1, (law, contact, start)
    print(
        f"\n1000 random launches: {dict(seen)}; true error over stated error: {worst:.2g} at most"
    )
    assert seen["undetermined"] < 20
