"""Random systems of a user with planted zeros, jumps of branch and symmetric spectra.

Claims are judged by exact arithmetic that shares no code with the package.  STABILITY_SEED chooses
other systems for the long campaigns, STABILITY_SYSTEMS how many.
"""

import os
import random
from collections import Counter

import numpy as np
import pytest
from exact_oracle import exact, isolated, sides
from flint import fmpq_poly
from judged_systems import Oracle, accept, judge_all
from random_boundaries import judge_search, search
from random_systems import MAKERS, case, hop

from stability.base.verdict import Verdict

SEED = int(os.environ.get("STABILITY_SEED", "1"))
SYSTEMS = int(os.environ.get("STABILITY_SYSTEMS", "20000"))


def planted_polynomial(draw: random.Random) -> tuple[fmpq_poly, tuple[int, int, int]]:
    """A polynomial, and how many roots lie left of, on and right of the imaginary axis."""
    poly, count = fmpq_poly([1]), [0, 0, 0]

    def put(a: float, b: float) -> None:
        nonlocal poly
        re, im = exact(a), exact(b)
        factor = fmpq_poly([re * re + im * im, -2 * re, 1]) if b else fmpq_poly([-re, 1])
        poly *= factor
        count[int(a > 0) - int(a < 0) + 1] += 2 if b else 1

    for _ in range(draw.randint(1, 5)):
        size = draw.choice([1e-30, 1e-3, 1.0, 2.5])
        b = draw.choice([1e-3, 1.0, 2.5])
        roll = draw.random()
        if roll < 0.35:
            for _ in range(draw.choice([1, 1, 2])):
                put(draw.choice([-1, 1]) * size, 0)
        elif roll < 0.6:
            put(0.0, b)
        elif roll < 0.8:
            put(draw.choice([-1, 1]) * size, b)
        else:
            put(size, b)
            put(-size, b)
    return poly, (count[0], count[1], count[2])


@pytest.mark.parametrize("systems", [70, pytest.param(400, marks=pytest.mark.long)])
def test_sturms_chain_and_isolated_roots_count_what_was_planted(systems: int) -> None:
    draw = random.Random(SEED)
    for _ in range(systems):
        poly, count = planted_polynomial(draw)
        assert sides(poly) == count
        roots = isolated(poly)
        assert tuple(sum(r.side == s for r in roots) for s in (-1, 0, 1)) == count


@pytest.mark.parametrize(
    ("claim", "wrong"),
    [
        (("stable", 1, [-1.0, -0.31], [1e-15, 1e-15]), "1 zeros dropped, 0 there"),
        (("stable", 0, [-1.0, -0.31, 0.031], [1e-15] * 3), "wrong verdict"),
        (("unstable", 0, [-1.0, -0.31, 0.031], [1e-15] * 3), ""),
        (("unstable", 0, [-1.0, -0.31, 0.032], [1e-15] * 3), "no disc holds"),
        (("undecided", 1, [-1.0, -0.31], [np.inf, np.inf]), ""),
    ],
)
def test_the_judge_knows_a_false_claim(
    claim: tuple[str, int, list[float], list[float]], wrong: str
) -> None:
    judge = Oracle(hop())
    [(member, asked)] = judge.nearest({"p": 0.31}, [1.31, 0.0, 0.0])
    verdict, zeros, values, radii = claim
    found = accept(judge, member, asked, (verdict, zeros, np.array(values) + 0j, np.array(radii)))
    assert found[1].startswith(wrong) and bool(found[1]) == bool(wrong)


def wrong_claims(kind: str, seeds: range) -> tuple[list[str], Counter[str]]:
    """What is wrong over seeds, and how often each verdict was given."""
    wrong, count = [], Counter[str]()
    for seed in seeds:
        for finding in judge_all(case(kind, seed)):
            route = "certified" if finding.certify else "default"
            count[f"{route} {finding.verdict}"] += 1
            count["not judged"] += finding.truth in ("unknown", "elsewhere")
            if finding.wrong:
                wrong.append(str(finding))
    return wrong, count


def answered(count: Counter[str]) -> float:
    """Share of what was asked that has a verdict."""
    words = {v.word for v in Verdict} - {Verdict.UNDECIDED.word}
    decided = sum(n for word, n in count.items() if word.split()[-1] in words)
    return decided / max(1, count.total() - count["not judged"])


def test_no_claim_about_two_random_systems_of_each_kind_is_wrong() -> None:
    whole = Counter[str]()
    for kind in MAKERS:
        wrong, count = wrong_claims(kind, range(1, 3))
        assert not wrong, "\n".join(wrong)
        whole += count
    assert answered(whole) > 0.4


@pytest.mark.long
@pytest.mark.parametrize("kind", MAKERS)
def test_no_claim_about_a_random_system_is_wrong(kind: str) -> None:
    wrong, count = wrong_claims(kind, range(14))
    assert not wrong, "\n".join(wrong)
    # most are answered, but for kinds that ask where nothing can be said
    assert answered(count) >= {"kinks": 0.0, "claimed": 0.05}.get(kind, 0.4)


@pytest.mark.parametrize("count", [5, pytest.param(40, marks=pytest.mark.long)])
def test_no_planted_change_of_verdict_is_missed_or_invented(count: int) -> None:
    wrong, ends = [], Counter[str]()
    for seed in range(count):
        one = search(seed)
        how, faults = judge_search(one)
        ends[how] += 1
        wrong += [f"{seed}: {fault}" for fault in faults]
    assert not wrong, "\n".join(wrong)
    assert ends["complete"] > count / 2


@pytest.mark.few(4)
@pytest.mark.parametrize(
    ("kind", "seed"),
    [
        ("branches", 7000059),  # a root at 0 was enclosed next to it
        ("folding", 14000017),  # a rounded sum of constants was taken for the structural zero
        ("lines", 7000065),  # a warning of NumPy's got out
        ("lines", 2105),  # large entries hid a structural zero
        ("factors", 7000000),
        ("functions", 1122000438),  # exp(-800) is no zero: its error was
        ("functions", 1122000667),
        ("branches", 1124001353),  # Newton's method left a double root for another branch
        ("lines", 1124001771),  # the same, and close to steady
        ("lines", 1122000142),  # typical members were roots of the equations, but not steady
        ("lines", 1122000532),  # the error of a tangent was that of a better solver than was used
        ("lines", 1122000563),  # a root at which another rate does not vanish was certified
        ("lines", 1122001159),  # unknowns that the equations leave open ended in an error of CasADi
        ("lines", 1122001285),  # no neighbourhood was reached where an unknown does not move
        ("lines", 1122001442),  # a power that is flat next to the member counted as structural
        ("products", 1122001086),  # 0/0 times zero was zero
        ("lines", 1000313),  # exact digits of a rational that solves nothing ended the process
        ("lines", 1000401),  # |x| y has a slope at y = 0, though |x| has none: neutral is right
    ],
)
def test_what_the_long_campaign_found_is_mended(kind: str, seed: int) -> None:
    assert not [str(f) for f in judge_all(case(kind, seed)) if f.wrong]


@pytest.mark.long
@pytest.mark.parametrize("kind", MAKERS)
def test_no_claim_about_twenty_thousand_random_systems_is_wrong(kind: str) -> None:
    first = 10**6 * SEED
    wrong, count = wrong_claims(kind, range(first, first + -(-SYSTEMS // len(MAKERS))))
    print(f"\n{kind}: " + ", ".join(f"{word} {n}" for word, n in sorted(count.items())))
    assert not wrong, "\n".join(wrong[:20])


@pytest.mark.long
def test_no_change_of_verdict_of_two_thousand_random_systems_is_missed() -> None:
    first = 10**6 * SEED
    wrong, ends = [], Counter[str]()
    for seed in range(first, first + SYSTEMS // 10):
        how, faults = judge_search(search(seed))
        ends[how] += 1
        wrong += [f"{seed}: {fault}" for fault in faults]
    print(f"\nboundaries: {dict(ends)}")
    assert not wrong, "\n".join(wrong[:20])
