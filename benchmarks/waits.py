"""Computing time of first calls: each runs in a new process, with its files in the cache.

    python benchmarks/waits.py [--repeat N] [--against PYTHON] [--atlas]

Times are user + system, of all processes, so that other work on the machine counts little; the
least of the repeats is printed.  PYTHON is the interpreter of another environment, with another
version of the package: both are then measured in turn, and the last column is their ratio.
`--atlas` adds the atlas at its default resolution and at 60, and the computing time until the
first of its figures is done.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

SIMULATE = "import stability as st; st.simulate(st.Disk(), st.Viscous(0.3), {}, {})"
START = {"theta": 1.5, "phi_dot": 0.1, "omega3": 1.8}
COMMAND = ["-m", "stability"]
CALL = "import stability as st; st."
WAITS = {
    "python": ["-c", "pass"],
    "casadi, numpy": ["-c", "import casadi, numpy"],
    "and xarray": ["-c", "import casadi, numpy, xarray"],
    "import stability": ["-c", "import stability"],
    "spectrum, call": ["-c", CALL + "spectrum('rolling', at=1.8, contact=st.Viscous(0.3))"],
    "map, 80 x 60": [
        "-c",
        CALL + "stability_map('rolling', x=('at', 0, 2, 80), y=('mu', 0.1, 2, 60))",
    ],
    "spectrum": [*COMMAND, "spectrum", "rolling", "--at", "1.8", "--mu", "0.3"],
    "simulate, 10": ["-c", SIMULATE.format(START, 10.0)],
    "simulate, 100": ["-c", SIMULATE.format(START, 100.0)],
    "table conditions": [*COMMAND, "table", "conditions"],
}
FIRST = """
import os, sys
from stability.atlas.build import atlas
def progress(done, total):
    if done:
        os._exit(0)
atlas(sys.argv[1], workers=1, overwrite=True, progress=progress)
"""
ATLAS = {
    "atlas": [*COMMAND, "atlas", "--force", "--out"],
    "atlas, 60": [*COMMAND, "atlas", "--resolution", "60", "--force", "--out"],
    "atlas, first figure": ["-c", FIRST],
}


def computing_time(python: str, arguments: list[str], folder: str) -> float:
    """User and system time of a new process and its children [s]."""
    words = [*arguments, str(Path(folder) / "atlas")] if arguments in ATLAS.values() else arguments
    before = os.times()
    subprocess.run([python, *words], check=True, cwd=folder, capture_output=True)
    after = os.times()
    return (after.children_user - before.children_user) + (
        after.children_system - before.children_system
    )


def main() -> None:
    """Measure and print, one line for each wait."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--against")
    parser.add_argument("--atlas", action="store_true")
    options = parser.parse_args()
    pythons = [sys.executable, *([options.against] if options.against else [])]
    print(f"{'':20}" + "".join(f"{name:>10}" for name in ("here [s]", "there [s]", "ratio")))
    with tempfile.TemporaryDirectory() as folder:
        for name, arguments in (WAITS | (ATLAS if options.atlas else {})).items():
            found = [
                [computing_time(python, arguments, folder) for python in pythons]
                for _ in range(options.repeat)
            ]
            least = [min(times) for times in zip(*found, strict=True)]
            ratio = f"{least[0] / least[1]:10.2f}" if len(least) > 1 else ""
            print(f"{name:20}" + "".join(f"{v:10.2f}" for v in least) + ratio, flush=True)


if __name__ == "__main__":
    main()
