"""Quantities found from a track whose states are known in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stability.scene.questions import QUESTIONS
from stability.scene.rungs.track import Track

SPEED, FALL = 1.0, 0.5


def passages(nearest: tuple[float, ...], offset: float) -> tuple[Track, float]:
    """A disk that falls ever faster and passes near flat: pulses 2.07 apart, sampled every 0.2.

    Near each, θ = √(d² + v²s²) - a s²/2 at a distance s in time.
    """
    middle = 2.07 * np.arange(len(nearest)) + 1.0  # samples are at another place in each pulse

    def at(times: Any) -> Any:
        one = np.abs(times[:, None] - middle).argmin(axis=1)
        s, d = times - middle[one], np.array(nearest)[one]
        root = np.sqrt(d**2 + (SPEED * s) ** 2)
        theta = root - FALL * s**2 / 2
        return np.stack([theta, SPEED**2 * s / root - FALL * s], -1)

    times = np.arange(offset, 2.0 * len(nearest), 0.2)
    return Track(times, at(times), np.zeros(len(times)), at), np.pi / 2 - min(nearest)


@pytest.mark.parametrize("offset", np.arange(0.0, 0.2, 0.013))
def test_the_largest_tilt_is_that_of_the_nearest_passage_near_flat(offset: float) -> None:
    track, largest = passages((5e-3, 4.97e-3, 1e-7, 4.6e-3, 9e-8), offset)
    found = QUESTIONS["largest_tilt"].find(None, track)  # type: ignore[arg-type]
    assert found.value == pytest.approx(largest, abs=1e-13)
    track, largest = passages((4.97e-3, 4.6e-3), offset)
    found = QUESTIONS["largest_tilt"].find(None, track)  # type: ignore[arg-type]
    assert found.value == pytest.approx(largest, abs=1e-13)
