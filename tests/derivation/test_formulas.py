"""Formulas and statements of the table of conditions: each is tried to be refuted."""

import json
import random
from dataclasses import asdict
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy

import stability as st
from stability.base.verdict import Verdict
from stability.cli import main
from stability.derivation.formulas import cases, formulas
from stability.spectra.certificate import verdict
from stability.spectra.problem import disk_problem
from stability.tables.conditions import formula_latex

Z, M, S, K = sympy.symbols("z M s k")


@pytest.mark.few(2)
@pytest.mark.parametrize("law", ["smooth", "viscous", "rough"])
@pytest.mark.parametrize("family", ["rolling", "spinning", "tumbling"])
def test_boundary_formulas_are_the_refined_boundary_curves_to_1e_12(family: str, law: str) -> None:
    laws: dict[str, Any] = {"smooth": st.Smooth(), "viscous": st.Viscous, "rough": st.Rough()}
    ends = {"rolling": (0.3, 4), "spinning": (0.6, 6), "tumbling": (0.02, 1.5707)}[family]
    other = ("mu", 0.05, 4, 25, "log") if law == "viscous" else ("k", 0.05, 0.5, 25)
    worst, seen = 0.0, 0
    for k in (0.1, 0.25, 0.375, 0.5):
        found = st.stability_map(
            family,
            x=("at", *ends, 40),
            y=other,
            contact=laws[law],
            disk=st.Disk(k=k) if other[0] == "mu" else None,
        )
        solved = formulas(family, law).boundaries
        functions = [
            (
                b["kind"],
                b["of"],
                sympy.lambdify((K, M, Z, S), sympy.sympify(b["formula"]), "mpmath"),
            )
            for b in solved
        ]
        other_values = found[f"boundary_{other[0]}"].values
        for at, value, kind in zip(
            found.boundary_at.values, other_values, found.boundary_kind.values, strict=True
        ):
            with mpmath.workdps(40):
                mu = mpmath.mpf(float(value)) if other[0] == "mu" else mpmath.mpf(1)
                inertia = mpmath.mpf(k) if other[0] == "mu" else mpmath.mpf(float(value))
                x = mpmath.mpf(float(at))
                off = []
                for named, of, function in functions:
                    if (named == "static") != (kind == 0):
                        continue
                    number = function(inertia, mu**2, x**2, mpmath.sin(x))
                    truth = mu**2 if of == "mu**2" else x**2
                    off.append(float(abs(mpmath.sqrt(number) / mpmath.sqrt(truth) - 1)))
                assert off, (family, law, kind)
                # solved for the axis along which the point was refined, or its slope is met
                worst = max(worst, min(off))
                seen += 1
        if other[0] == "k":
            break
    if (family, law) in (("tumbling", "smooth"), ("tumbling", "rough")):
        assert seen == 0
    else:
        assert seen > 15
        assert worst < 1e-12


CLAIMS = [
    (family, law, k)
    for family, law in cases(["smooth", "viscous", "rough"])
    if family not in ("circling", "precession")
    for k in ("0.25", "0.375", "0.5")
]


SEVERAL = ("0.25", "0.34", "0.27195394608109374", "0.375", "0.5", "0.01")


def decided(family: str, law: str, k: float, mu: float, at: float) -> Verdict:
    contact = {"smooth": st.Smooth(), "viscous": st.Viscous(mu), "rough": st.Rough()}[law]
    asked = disk_problem(family, st.Disk(k=k), contact, at)
    return verdict(asked, {n: float(v) for n, v in asked.values.items()})


@pytest.mark.parametrize(
    ("k", "probes"),
    [("0.25", 3), *(pytest.param(k, 12, marks=pytest.mark.long) for k in ("all", *SEVERAL))],
)
def test_ranges_of_spinning_hold_wherever_they_are_probed(k: str, probes: int) -> None:
    random = np.random.default_rng(3)
    value = float(random.uniform(1e-3, 0.5)) if k == "all" else float(k)
    ranges = [
        r
        for r in formulas("spinning", "viscous", () if k == "all" else (k,)).ranges
        if (r["k"] == "all") == (k == "all")
    ]
    assert len(ranges) == 3
    for trial in range(4 if probes > 3 else 1):
        if k == "all":
            value = float([1e-3, 0.5, 0.1, 0.499][trial])
        for r in ranges:
            low, high = (
                float(sympy.sympify(r[end].rstrip("…")).subs(K, sympy.Float(value, 30)))
                if r[end] != "oo"
                else 1e4
                for end in ("low", "high")
            )
            for share in (1e-6, 0.3, 0.9, 1 - 1e-6):
                mu = (low + share * (high - low)) ** 0.5
                at = value**-0.5 * (1 + 10.0 ** random.uniform(-9, 4, probes))
                found = [decided("spinning", "viscous", value, mu, a) for a in np.sort(at)]
                words = [v.word for i, v in enumerate(found) if i == 0 or v is not found[i - 1]]
                if r["pattern"].startswith("stable, then unstable"):
                    assert words in (["stable", "unstable"], ["stable"], ["unstable"])
                else:
                    assert words == [r["pattern"].split()[0]]
                below = decided(
                    "spinning", "viscous", value, mu, value**-0.5 * random.uniform(0, 1)
                )
                assert below is Verdict.UNSTABLE


@pytest.mark.long
@pytest.mark.parametrize(("k", "probes"), [("0.34", 12), *((k, 50) for k in SEVERAL)])
def test_ranges_of_tumbling_hold_wherever_they_are_probed(k: str, probes: int) -> None:
    random = np.random.default_rng(4)
    ranges = formulas("tumbling", "viscous", (k,)).ranges
    assert ranges[0]["low"] == "0" and ranges[-1]["high"] == "oo"
    for before, after in zip(ranges[:-1], ranges[1:], strict=True):
        assert before["high"] == after["low"]
    for r in ranges:
        low, high = r["mu_low"], min(r["mu_high"], 2 * r["mu_low"] + 0.5)
        told = [w.split()[0] for w in r["pattern"].split(", then ")]
        full = 0
        for share in (1e-5, 0.2, 0.5, 0.9, 1 - 1e-5):
            mu = low + share * (high - low)
            theta = np.concatenate(
                [
                    10 ** random.uniform(-5, 0, 3 * probes),
                    np.pi / 2 - 10 ** random.uniform(-7, 0, 3 * probes),
                    random.uniform(0.01, 1.57, 2 * probes),
                ]
            )
            found = [decided("tumbling", "viscous", float(k), mu, a) for a in np.sort(theta)]
            words = [v.word for i, v in enumerate(found) if i == 0 or v is not found[i - 1]]
            # a narrow stretch may lie between two probes, but nothing else may be seen
            position = iter(told)
            assert all(w in position for w in words), (words, told)
            full += words == told
        assert full >= 3


@pytest.mark.parametrize("k", [1e-3, 0.25, 0.5])
@pytest.mark.parametrize("law", ["smooth", "rough", "viscous"])
def test_every_plain_statement_survives_extreme_points(law: str, k: float) -> None:
    """Rolling's one threshold for every mu; tumbling neutral for every theta without friction."""
    random = np.random.default_rng(5)
    if law == "viscous":
        assert "every mu" in formulas("rolling", "viscous").statements[0]
        for mu in 10 ** random.uniform(-8, 8, 30):
            for step in (1e-12, 1e-3, 10.0):
                at = (2 * k) ** -0.5
                assert decided("rolling", law, k, mu, at * (1 + step)) is Verdict.STABLE
                assert decided("rolling", law, k, mu, at / (1 + step)) is Verdict.UNSTABLE
    else:
        assert formulas("tumbling", law).statements[0].endswith("every theta: neutral")
        for theta in 10 ** random.uniform(-6, 0.19, 40):
            assert decided("tumbling", law, k, 1.0, theta) is Verdict.NEUTRAL


@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.long)])
def test_limits_are_those_of_the_verdicts(whole: bool) -> None:
    for family in ("spinning", "tumbling") if whole else ("spinning",):
        limits = formulas(family, "viscous", ("0.25",)).limits
        random = np.random.default_rng(6)
        for limit, mu in (("mu -> 0", 1e-9), ("mu -> oo", 1e9)):
            [text] = limits[limit]
            value = sympy.lambdify((K, Z, S), sympy.sympify(text))
            for _ in range(60 if whole else 8):
                k, x = random.uniform(1e-2, 0.5), random.uniform(0.05, 1.5)
                at = x if family == "tumbling" else k**-0.5 * (1 + x)
                sign = value(k, at**2, np.sin(at))
                if abs(sign) > 1e-6:
                    wanted = Verdict.STABLE if sign > 0 else Verdict.UNSTABLE
                    assert decided(family, "viscous", k, mu, at) is wanted


def test_the_decomposition_can_fail() -> None:
    """A condition whose pattern changes with k is not called one cell."""
    from stability.derivation.formulas import FlutterCondition

    odd = (4 * K - 1) * Z * K - M
    assert FlutterCondition("spinning", sympy.expand(odd), 1 / K).for_every_k() is None


def test_the_table_prints_text_latex_and_json(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["table", "conditions", "--contact", "rough", "--k", "0.25"]
    assert main(words) == 0
    shown = capsys.readouterr().out
    assert "det(λ - A) ~ λ^2 (k*lam**2 + k*z + lam**2 + z - 1)" in shown
    assert "recomputed" in shown
    assert main([*words, "--json"]) == 0
    body = json.loads(capsys.readouterr().out)
    assert {f["family"] for f in body["formulas"]} == {
        "rolling",
        "spinning",
        "tumbling",
        "circling",
    }
    assert body["rows"]
    assert main([*words, "--latex"]) == 0
    shown = capsys.readouterr().out
    assert shown.count("\\begin{itemize}") == shown.count("\\end{itemize}") == 4
    assert "\\frac{1}{k + 1}" in shown


@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.long)])
def test_latex_has_balanced_braces_and_dollars(whole: bool) -> None:
    few = [("spinning", "viscous"), *cases(["rough"])]
    for family, law in cases(["viscous", "rough"]) if whole else few:
        text = formula_latex([asdict(formulas(family, law, ("0.25",)))])
        assert text.count("{") == text.count("}")
        assert text.count("$") % 2 == 0
        assert "**" not in text and "…" not in text.split("\\item")[1]


def test_tables_of_drift_and_hopf_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["table", "drift", "--k", "0.25", "--mu", "1", "--tilt", "0.01,0.02"]) == 0
    shown = capsys.readouterr().out
    assert shown.count("\n0.25") == 8
    assert main(["table", "hopf", "--k", "0.375", "--mu", "0.9", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert [r["kind"] for r in rows] == ["elliptic", "elliptic", "hyperbolic"]


@pytest.mark.parametrize("count", [3, pytest.param(40, marks=pytest.mark.long)])
def test_roots_and_factors_are_those_of_computer_algebra(count: int) -> None:
    from stability.derivation.formulas import _irreducible, _real_roots

    x, y = sympy.symbols("x y")
    for seed in range(count):
        draw = random.Random(seed)
        parts = [
            sympy.Poly([draw.randint(1, 9), *(draw.randint(-9, 9) for _ in range(n))], x)
            for n in draw.choices((1, 2, 3, 4), k=3)
        ]
        poly = parts[0] * parts[1] ** draw.choice([1, 2]) * parts[2] * sympy.Rational(1, 7)
        known = sorted(set(poly.real_roots(radicals=False)))
        found = sorted(set(_real_roots(poly)))
        assert len(found) == len(known)
        for mine, theirs in zip(found, known, strict=True):
            assert mine == theirs if theirs.is_rational else abs(mine - theirs.evalf(60)) < 1e-55
        mixed = sympy.expand(parts[0].as_expr() * (x * y - draw.randint(1, 5)) * (y + 3))
        theirs = {f for f, _ in sympy.factor_list(mixed)[1]}
        mine = set(_irreducible(mixed))
        assert len(mine) == len(theirs)
        assert all(
            any(sympy.expand(m - sign * t) == 0 for t in theirs for sign in (1, -1)) for m in mine
        )
