"""Random launches depend on their index and the seed alone, and have the distribution they say."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from stability.base.errors import ParameterError
from stability.basin.statistics.samples import (
    Ball,
    Independent,
    LogUniform,
    Normal,
    Uniform,
    sample,
    shares,
)

MIXED = {"theta": Uniform(0.1, 1.5), "omega3": Normal(2.0, 0.1), "mu": LogUniform(1e-3, 10)}
WIDE = {f"q{n}": Uniform(n, n + 1) for n in range(7)}
BALL = Ball({"a": 1.0, "b": -2.0, "c": 0.0}, {"a": 0.5, "b": 2.0, "c": 1e-3})


@pytest.mark.parametrize("distribution", [MIXED, WIDE, BALL])
def test_chunks_of_any_size_in_any_order_give_identical_launches(distribution: object) -> None:
    whole = sample(distribution, 0, 500, seed=11)
    order = np.random.default_rng(2)
    for _ in range(20):
        cuts = np.unique(np.concatenate([[0, 500], order.integers(0, 500, 9)]))
        pieces = list(zip(cuts[:-1], cuts[1:], strict=True))
        got = np.full_like(whole, np.nan)
        for k in order.permutation(len(pieces)):
            a, b = (int(n) for n in pieces[k])
            got[a:b] = sample(distribution, a, b - a, seed=11)
        assert (got == whole).all()


def test_numbers_are_those_of_an_independent_philox() -> None:
    """The published generator, in integers: ten rounds, counter + 1 for the first block."""
    mask = 2**64 - 1

    def block(counter: int, key: int) -> list[int]:
        c = [(counter >> 64 * n) & mask for n in range(4)]
        k = [key & mask, key >> 64]
        for r in range(10):
            if r:
                k = [(k[0] + 0x9E3779B97F4A7C15) & mask, (k[1] + 0xBB67AE8584CAA73B) & mask]
            a, b = 0xD2E7470EE14C6C93 * c[0], 0xCA5A826395121157 * c[2]
            c = [(b >> 64) ^ c[1] ^ k[0], b & mask, (a >> 64) ^ c[3] ^ k[1], a & mask]
        return c

    for seed in (0, 5, 2**100 + 3):
        for index in (0, 1, 10**12):
            raw = [w for n in (1, 2) for w in block(2 * index + n, seed)][:6]
            wanted = [((w >> 11) + 0.5) * 2.0**-53 for w in raw]
            assert shares(6, index, 1, seed)[0].tolist() == wanted


def test_each_quantity_has_its_distribution() -> None:
    got = sample(MIXED, 0, 20000, seed=1)
    laws = (stats.uniform(0.1, 1.4), stats.norm(2.0, 0.1), stats.loguniform(1e-3, 10))
    for column, law in zip(got.T, laws, strict=True):
        assert stats.kstest(column, law.cdf).pvalue > 1e-3
    assert np.abs(np.corrcoef(got.T) - np.eye(3)).max() < 4 / np.sqrt(20000)


def test_a_ball_is_even() -> None:
    got = (sample(BALL, 0, 20000, seed=4) - [1, -2, 0]) / [0.5, 2, 1e-3]
    distance = np.linalg.norm(got, axis=1)
    assert stats.kstest(distance**3, "uniform").pvalue > 1e-3
    for column in (got / distance[:, None]).T:  # Archimedes: a coordinate on the sphere is even
        assert stats.kstest(column, stats.uniform(-1, 2).cdf).pvalue > 1e-3


def test_seeds_and_indices_are_independent() -> None:
    a, b = sample(MIXED, 0, 2000, seed=1), sample(MIXED, 0, 2000, seed=2)
    assert not (a == b).any()
    assert len(np.unique(a[:, 0])) == 2000
    assert abs(np.corrcoef(a[:-1, 0], a[1:, 0])[0, 1]) < 4 / np.sqrt(2000)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Uniform(2, 1), "runs from 2 to 1"),
        (lambda: LogUniform(0, 1), "above zero"),
        (lambda: Normal(0, 0), "deviation"),
        (lambda: Independent({}), "at least one"),
        (lambda: sample({"a": 3}, 0, 1), "distribution of a is 3"),
        (lambda: sample(7, 0, 1), "the distribution is 7"),
        (lambda: sample(MIXED, -1, 1), "first"),
        (lambda: sample(MIXED, 0, 1, seed=-1), "seed"),
        (lambda: Ball({"a": 1}, {"b": 1}), "same names"),
    ],
)
def test_refusals_say_what_is_wrong(call: object, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        call()
