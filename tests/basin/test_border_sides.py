"""Both sides of refined borders are confirmed by an integrator that shares no code."""

from collections import Counter

import disk_ends
import numpy as np
import pytest
from disk_ends import ends
from kane_disk import fixed_axes

import stability as st
from stability.basin.borders import borders

SURE = {
    "settled on spinning": "spinning",
    "settled on tumbling": "tumbling",
    "lift-off": "lift-off",
}
"""Labels that say how a launch ends, and the oracle's words for them."""


PLACES = {
    "spinning": ("phi_dot", (2.2, 4.6), (0.05, 0.95), 2),
    "rolling": ("omega3", (1.1, 1.38), (0.02, 0.14), 3),
}
"""Name of the member, ends of both axes, and the place of the name among the six states."""


def sides(
    coarse: int, levels: int, horizon: float, family: str = "spinning", *, moving: bool = True
) -> tuple[np.ndarray, list[str], list[str]]:
    """Launches on both sides of every refined border, their labels, and the oracle's words.

    Without `moving` those that still move stay open: next to flat they would take the oracle a
    million steps.
    """
    own, across, along, place = PLACES[family]
    label = st.launch_labels(
        contact="viscous", mu=0.3, family=family, varied=(own, "tilt"), horizon=horizon
    )
    found = borders(label, (own, *across, coarse), ("tilt", *along, coarse), levels=levels)
    launches, first = np.unique(found.pairs.reshape(-1, 2), axis=0, return_index=True)
    words = [label.words(int(i)) for i in found.pair_labels.ravel()[first]]
    starts = np.zeros((len(launches), 6))
    starts[:, 0], starts[:, place] = np.pi / 2 - launches[:, 1], launches[:, 0]
    sure = np.array([moving or word in SURE for word in words])
    true = np.full(len(words), "open", dtype=object)
    true[sure] = ends(starts[sure], 0.25, 0.3, horizon)
    return launches, words, [str(t) for t in true]


def judged(words: list[str], true: list[str]) -> Counter[str]:
    """How many sides the oracle confirms, contradicts, or leaves open."""
    kinds = Counter[str]()
    for word, other in zip(words, true, strict=True):
        plain = word in SURE and other != "open"
        kinds["open" if not plain else "same" if SURE[word] == other else "other"] += 1
    return kinds


def test_sides_of_a_coarse_border_of_early_lift_off_are_confirmed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By the formulation in fixed axes, which needs no derivation."""
    monkeypatch.setattr(disk_ends, "kane", fixed_axes)
    _, words, true = sides(4, 0, 1.5)
    left = [word == "lift-off" for word in words]
    assert len(words) >= 6 and 0.2 < np.mean(left) < 0.8
    assert left == [other == "lift-off" for other in true]


@pytest.mark.long
def test_sides_of_a_coarse_border_are_confirmed() -> None:
    launches, words, true = sides(5, 0, 120.0)
    found = judged(words, true)
    wrong = [
        (*map(float, launches[i]), words[i], true[i])
        for i in range(len(words))
        if words[i] in SURE and true[i] not in ("open", SURE[words[i]])
    ]
    assert found["other"] == 0, wrong
    assert len(words) >= 12
    assert found["open"] <= 0.2 * len(words)
    assert len({w for w in words if w in SURE}) == 3


@pytest.mark.long
def test_sides_of_the_border_of_lift_off_near_rolling_are_confirmed() -> None:
    """Slow rolling falls: by t = 40 it has left the plane, or it has not."""
    _, words, true = sides(4, 1, 40.0, "rolling")
    left = [word == "lift-off" for word in words]
    assert len(words) >= 12 and 0.2 < np.mean(left) < 0.8
    assert left == [other == "lift-off" for other in true]


@pytest.mark.long
def test_sides_of_a_border_near_rolling_are_confirmed() -> None:
    """It leaves the plane, or settles on tumbling; next to the border some still move."""
    _, words, true = sides(6, 1, 800.0, "rolling", moving=False)
    found = judged(words, true)
    assert found["other"] == 0, list(zip(words, true, strict=True))
    assert found["same"] >= 30 and found["same"] > 2 * found["open"], found
    assert {w for w in words if w in SURE} == {"settled on tumbling", "lift-off"}


@pytest.mark.long
def test_sides_of_hundreds_of_border_points_are_confirmed() -> None:
    """Near the border of two rests all is slow: at t = 400 one side in seven still moves."""
    launches, words, true = sides(9, 4, 20000.0)
    found = judged(words, true)
    wrong = [
        (*map(float, launches[i]), words[i], true[i])
        for i in range(len(words))
        if words[i] in SURE and true[i] not in ("open", SURE[words[i]])
    ]
    assert found["other"] == 0, wrong
    assert len(words) >= 400
    assert found["open"] == 0
    assert len({w for w in words if w in SURE}) == 3
