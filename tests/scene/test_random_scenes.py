"""Random scenes of every kind, each answer held against the full model at a fine tolerance."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence

import numpy as np
import pytest
from random_scenes import Held, hold

SEED = int(os.environ.get("STABILITY_SEED", "20261122"))
COUNT = int(os.environ.get("STABILITY_SCENES", "2000"))
PARTS = 10


def _held(numbers: Sequence[int], seed: int) -> list[Held]:
    return [h for h in (hold(number, seed) for number in numbers) if h is not None]


@pytest.mark.parametrize(
    ("numbers", "seed"),
    [
        ((2, 3, 5, 7, 8, 9, 10, 11, 1249), 20261122),  # quick ones, by five models
        *(pytest.param(range(i, COUNT, PARTS), SEED, marks=pytest.mark.long) for i in range(PARTS)),
    ],
    ids=["nine", *(f"part {i}" for i in range(PARTS))],
)
def test_answers_keep_their_tolerance_and_estimates_are_near_the_truth(
    numbers: Sequence[int], seed: int
) -> None:
    held = _held(numbers, seed)
    claimed = [h for h in held if h.claimed]
    missed = [h for h in claimed if h.missed]
    lines = [
        f"{h.number} {h.quantity} {h.scene.contact!r} by {h.answer.model}: true {h.true:.3g}, "
        f"estimate {h.answer.estimate:.3g}, tolerance {h.scene.tolerance:.3g}, truth within "
        f"{h.known:.2g}; {h.note}"
        for h in missed
    ]
    ratios = np.array(
        [
            h.answer.estimate / h.true
            for h in claimed
            if h.quantity in ("final", "path") and h.true > 1e-12 and h.known < h.true / 3
        ]
    )
    print(f"\n{len(held)} scenes, {len(claimed)} answered, {len(missed)} outside the tolerance")
    print(dict(Counter(h.answer.model for h in held).most_common()))
    quantiles = np.quantile(ratios, [0, 0.02, 0.05, 0.25, 0.5, 0.75, 0.95, 0.98, 1]).round(2)
    print(f"estimate over truth, {len(ratios)} scenes: quantiles {quantiles}")
    print("\n".join(lines))
    assert not missed, lines
    assert len(claimed) > len(numbers) / 2
    assert (np.abs(np.log(ratios)) >= np.log(30)).sum() <= max(1, 0.1 * len(ratios))
    # every kind of rung is among them
    assert len({h.answer.model for h in claimed}) >= 5
