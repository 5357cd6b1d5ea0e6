"""The towed wheel of examples/towed_wheel.py: three states, seven quantities."""

import runpy
from pathlib import Path

import stability as st

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "towed_wheel.py"
GIVEN: dict[str, float] = runpy.run_path(str(EXAMPLE))["GIVEN"]


def towed_wheel() -> st.Family:
    family: st.Family = runpy.run_path(str(EXAMPLE))["straight"]
    return family
