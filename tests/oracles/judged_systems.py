"""Claims about a random system, judged by the truth that exact arithmetic gives."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import flint
import numpy as np
from exact_oracle import (
    BITS,
    Balls,
    Dual,
    Graph,
    Irrational,
    Kink,
    Meaningless,
    Rationals,
    Root,
    Truth,
    at_bits,
    exact,
    middle,
    nullity,
    sloped,
    spectrum_of,
    strip,
)
from flint import acb, arb, arb_mat, fmpq, fmpq_poly
from random_systems import Case, point

import stability as st

TRIPLE = 1e-18
"""What a triple root moves at most where the equation does by 2^-200; below any rounding of one."""


@dataclass
class Finding:
    """One claim, and what is wrong with it (nothing where `wrong` is empty)."""

    kind: str
    seed: int
    asked: list[dict[str, float]]
    certify: bool
    verdict: str
    truth: str
    wrong: str = ""
    reason: str = ""
    zeros: int = -1

    def __str__(self) -> str:
        return (
            f"{self.kind} {self.seed} certify={self.certify} asked={self.asked}: "
            f"said {self.verdict} (zeros {self.zeros}), truth {self.truth}; "
            f"{self.wrong}; {self.reason}"
        )


class Oracle:
    """Truths about one system: the graph, its plan and its branches over any ring."""

    def __init__(self, case: Case) -> None:
        self.case = case
        x, p = case.system.x, case.system.p
        self.states, self.parameters = case.system.states, case.system.parameters
        self.rates = Graph(x, p, case.system.rhs)
        unknown = case.family.unknown
        self.branches = [
            Graph(x, p, ca.vertcat(*[b[name] for name in unknown])) for b in case.branches
        ]
        self.implicit = None if case.implicit is None else Graph(x, p, case.implicit)
        shapes = case.planned or []
        self.shapes = [Graph(x, p, ca.vertcat(*s[1:])) for s in shapes]

    def members(self, ring: Any, asked: dict[str, Any]) -> list[list[Any]]:
        """Every exact member at a point; with several unknowns there is one at most."""
        x: list[Any] = [fmpq(0)] * len(self.states)
        q = [asked[name] for name in self.parameters]
        for i, name in enumerate(self.states):
            if name in asked:
                x[i] = asked[name]
            elif name in self.case.family.held:
                x[i] = ring.number(float(self.case.family.held[name]))
        found = []
        unknown = [self.states.index(name) for name in self.case.family.unknown]
        if not unknown:
            return [x]
        if self.implicit is not None:
            coefficients = [d.value for d in self.implicit(Rationals(), x, q)]
            for value in real_roots_of(fmpq_poly(coefficients)):
                found.append([*x[: unknown[0]], value, *x[unknown[0] + 1 :]])
            return found
        for branch in self.branches:
            try:
                values = [d.value for d in branch(ring, x, q)]
            except Meaningless:
                continue
            y = list(x)
            for i, value in zip(unknown, values, strict=True):
                y[i] = value
            found.append(y)
        return found

    def truth(self, x: Sequence[Any], asked: dict[str, Any]) -> Truth:
        """The spectrum at one exact member, rational where that is possible."""
        q = [asked[name] for name in self.parameters]
        try:
            if any(isinstance(v, arb) for v in x):
                raise Irrational
            out = sloped(self.rates(Rationals(), x, q))
        except Irrational:
            return at_bits(BITS, lambda: self.ball_truth(x, q))
        roots, zeros = spectrum_of([d.slope for d in out])
        steady = all(d.value == 0 for d in out)
        drifts = zeros > nullity([d.slope for d in out], Rationals())
        result = Truth(roots, zeros, steady=steady, drifts=drifts)
        self.check_plan(result, x, q)
        return result

    def planned(self, ring: Any, x: Sequence[Any], q: Sequence[Any]) -> list[list[Dual]]:
        return [g(ring, x, q) for g in self.shapes]

    def check_plan(self, truth: Truth, x: Sequence[Any], q: Sequence[Any]) -> None:
        """The plan's own eigenvalues agree with those of the graph: signs and zeros."""
        if not self.shapes:
            return
        try:
            roots, zeros = self.plan_roots(Rationals(), x, q)
        except Irrational:
            return
        assert zeros == truth.zeros, (self.case.kind, self.case.seed, zeros, truth.zeros)
        for side in (-1, 0, 1):
            assert sum(r.side == side for r in roots) == truth.count(side), (
                self.case.kind,
                self.case.seed,
                q,
            )

    def plan_roots(self, ring: Any, x: Sequence[Any], q: Sequence[Any]) -> tuple[list[Root], int]:
        roots: list[Root] = []
        zeros = 0
        for shape, graph in zip(self.case.planned or [], self.shapes, strict=True):
            values = [d.value for d in graph(ring, x, q)]
            sides = [ring.sign(v) for v in values]
            a = arb(values[0]) if sides[0] else arb(0)
            if shape[0] == "re":
                if sides[0]:
                    roots.append(Root(acb(a), sides[0]))
                else:
                    zeros += 1
            elif shape[0] == "pair":
                b = arb(values[1])
                roots += [Root(acb(a, b), sides[0]), Root(acb(a, -b), sides[0])]
            elif sides[0] == 0:
                zeros += 2
            elif sides[0] > 0:
                r = a.sqrt()
                roots += [Root(acb(r), 1), Root(acb(-r), -1)]
            else:
                r = (-a).sqrt()
                roots += [Root(acb(0, r), 0), Root(acb(0, -r), 0)]
        return roots, zeros

    def ball_truth(self, x: Sequence[Any], q: Sequence[Any]) -> Truth:
        """Irrational entries: the plan's eigenvalues, held against the graph's polynomial."""
        ring = Balls()
        out = sloped(self.rates(ring, x, q))
        matrix = arb_mat([[arb(s) for s in d.slope] for d in out])
        poly = matrix.charpoly()
        steady = all(arb(d.value).contains(0) for d in out)
        if self.case.planned is None:
            return Truth([], -1, note="no exact truth", steady=steady)
        roots, zeros = self.plan_roots(ring, x, q)
        product = flint.acb_poly([acb(0)] * zeros + [acb(1)])
        for r in roots:
            product *= flint.acb_poly([-r.value, acb(1)])
        for i in range(len(self.states) + 1):
            assert acb(poly[i]).overlaps(product[i]), (self.case.kind, self.case.seed, i)
        drifts = zeros > nullity([d.slope for d in out], ring)
        return Truth(roots, zeros, steady=steady, drifts=drifts)

    def nearest(
        self, asked: dict[str, float], found: Sequence[float]
    ) -> list[tuple[list[Any], dict[str, Any]]]:
        """The exact members that the reported states may mean."""
        values = {k: exact(v) for k, v in asked.items()}
        try:
            members = self.members(Rationals(), values)
        except Irrational:
            members = at_bits(BITS, lambda: self.members(Balls(), values))
        gaps = [
            max(abs(middle(v) - f) / (1 + abs(f)) for v, f in zip(m, found, strict=True))
            for m in members
        ]
        close = [m for m, g in zip(members, gaps, strict=True) if g < 1e-5]
        tight = [m for m, g in zip(members, gaps, strict=True) if g <= 1e-9 and g == min(gaps)]
        alone = tight if sum(g < 1e-5 for g in gaps) == len(tight) else close
        return [(m, values) for m in alone]

    def own_root(self, asked: dict[str, float], found: Sequence[float]) -> list[Any] | None:
        """The root of the solved equations next to reported unknowns, by Newton's method.

        A system drawn at random may have roots that its plan does not know, some of them closer to
        a planned one than a double tells.
        """
        unknown = [self.states.index(n) for n in self.case.family.unknown]
        rows = [self.states.index(n) for n in self.case.family.equations]
        if not unknown:
            return None

        def refine() -> list[Any] | None:
            x = [arb(exact(v)) for v in found]
            for i, name in enumerate(self.states):
                if name in asked:
                    x[i] = arb(exact(asked[name]))
            q = [arb(exact(asked[name])) for name in self.parameters]
            for _ in range(80):  # next to a double root it only halves the distance
                out = self.rates(Balls(), x, q)
                slope = arb_mat([[arb(out[r].slope[c]).mid() for c in unknown] for r in rows])
                right = arb_mat([[arb(out[r].value).mid()] for r in rows])
                try:
                    step = slope.solve(right)
                except ZeroDivisionError:
                    return None
                for i, c in enumerate(unknown):
                    x[c] = (x[c] - step[i, 0]).mid()
            small = all(abs(step[i, 0]) < arb(2) ** -250 for i in range(len(unknown)))
            near = all(abs(middle(x[i]) - v) <= 1e-9 * (1 + abs(v)) for i, v in enumerate(found))
            return x if small and near else None

        try:
            root: list[Any] | None = at_bits(BITS, refine)
        except Meaningless:
            return None
        return root

    def elsewhere(
        self, x: Sequence[Any], asked: dict[str, float], claim: Any, certify: bool
    ) -> str:
        """What is wrong with a claim about such a root; sides and discs are held against it.

        A rate within the rounding of double precision counts as zero where no proof is claimed.
        """
        verdict, zeros, eigenvalues, radii = claim

        def look() -> str:
            q = [arb(exact(asked[name])) for name in self.parameters]
            out = sloped(self.rates(Balls(), x, q))
            size = max(abs(float(middle(v))) for v in x)
            noise = 0.0 if certify else 2.0**-50 * size
            steep = [max(abs(float(middle(s))) for s in d.slope) for d in out]
            most = [1e-60 + noise * s for s in steep]
            if any(abs(middle(d.value)) > m for d, m in zip(out, most, strict=True)):
                return "" if verdict == "undecided" else "decided where the motion is not steady"
            poly = arb_mat([[arb(s) for s in d.slope] for d in out]).charpoly()
            if any(abs(middle(poly[i])) > 1e-60 for i in range(zeros)):
                return f"{zeros} zeros dropped, fewer there"
            rest = fmpq_poly([poly[i].mid().fmpq() for i in range(zeros, len(self.states) + 1)])
            roots = [root for root, n in rest.numer().complex_roots() for _ in range(n)]
            most = max(float(root.real.mid()) for root in roots)
            if (verdict, most > 0) in (("stable", True), ("unstable", False)):
                return "wrong verdict at a root of its own"
            for root in roots:
                value = complex(float(root.real.mid()), float(root.imag.mid()))
                slack = 1e-15 * abs(value) + 1e-25
                if (
                    verdict != "undecided"
                    and not (np.abs(eigenvalues - value) <= radii * (1 + 1e-12) + slack).any()
                ):
                    return f"no disc holds the eigenvalue {value}"
            return ""

        found: str = at_bits(BITS, look)
        return found

    def rests(self, asked: dict[str, float], found: Sequence[float]) -> bool:
        """Whether rates nearly vanish at reported states that no planned member explains."""

        def largest() -> float:
            x = [arb(exact(v)) for v in found]
            q = [arb(exact(asked[name])) for name in self.parameters]
            return max(abs(middle(d.value)) for d in self.rates(Balls(), x, q))

        return at_bits(BITS, largest) < 1e-9

    def generic(self, x: Sequence[Any], asked: dict[str, Any]) -> int | None:
        """Zeros that stay when the point moves a little; None if it depends where to."""
        chance = random.Random(f"{self.case.kind} {self.case.seed}")
        counts = set()  # of the branches that meet there, others may be a rounding away
        for sign in (-1, 1):
            moved = {
                k: v + sign * fmpq(chance.randint(10**8, 10**9), 10**9) / 2**200
                for k, v in asked.items()
            }
            try:
                members = self.members(Rationals(), moved)
            except Irrational:
                members = at_bits(BITS, lambda m=moved: self.members(Balls(), m))

            def close(m: Sequence[Any]) -> bool:
                return all(abs(arb(a) - arb(b)) < TRIPLE for a, b in zip(m, x, strict=True))

            near = [m for m in members if at_bits(BITS, lambda m=m: close(m))]
            if not near:
                return None
            for m in near:
                truth = self.truth(m, moved)
                if truth.note:
                    return None
                counts.add(truth.zeros)
        return counts.pop() if len(counts) == 1 else None


def real_roots_of(poly: fmpq_poly) -> list[Any]:
    """Real roots, exact where rational, each once."""
    found: list[Any] = []
    poly, zeros = strip(poly)
    if zeros:
        found.append(fmpq(0))
    if poly.degree() == 0:
        return found

    def isolate() -> list[Any]:
        roots: list[Any] = []
        for factor, _ in poly.numer().factor()[1]:
            if factor.degree() == 1:
                roots.append(fmpq(-factor[0], factor[1]))
            else:
                roots += [acb(v).real for v, _ in factor.complex_roots() if acb(v).imag == 0]
        return roots

    return found + at_bits(2 * BITS, isolate)


# --- judging ----------------------------------------------------------------------------------


def enclosed(roots: Sequence[acb], discs: np.ndarray, radii: np.ndarray) -> str:
    """Whether discs hold the roots: each component of k discs holds k of them."""
    n = len(discs)
    if not np.all(np.isfinite(radii)):
        return ""
    group = list(range(n))
    for i in range(n):
        for j in range(i):
            if abs(discs[i] - discs[j]) <= (radii[i] + radii[j]) * (1 + 1e-12):
                old, new = group[i], group[j]
                group = [new if g == old else g for g in group]
    held = {g: 0 for g in group}

    def place() -> str:
        for root in roots:
            for i in range(n):
                centre = acb(exact(discs[i].real), exact(discs[i].imag))
                if (
                    not abs(root - centre)
                    > arb(exact(radii[i])) * (1 + arb(2) ** -45) + arb(2) ** -1080
                ):
                    held[group[i]] += 1
                    break
            else:
                return f"no disc holds the eigenvalue {root.str(20)}"
        for g in held:
            if held[g] != group.count(g):
                return f"{group.count(g)} touching discs hold {held[g]} eigenvalues"
        return ""

    return at_bits(400, place)


def accept(
    oracle: Oracle, member: Sequence[Any], asked: dict[str, Any], claim: Any
) -> tuple[str, str]:
    """(truth in a word, what is wrong with the claim): verdict, zeros, eigenvalues, radius."""
    verdict, zeros, eigenvalues, radius = claim
    try:
        truth = oracle.truth(member, asked)
    except Kink:
        return "no linearisation", "" if verdict == "undecided" else "decided at a corner"
    except Meaningless:
        return "no meaning", "" if verdict == "undecided" else "decided where rates mean nothing"
    if truth.note:
        return "unknown", ""
    word = truth.verdict(zeros)
    if not truth.steady:
        return word, "" if verdict == "undecided" else "decided where the motion is not steady"
    if zeros > truth.zeros:
        wrong = f"{zeros} zeros dropped, {truth.zeros} there"
        return f"{truth.zeros} zeros", "" if verdict == "undecided" else wrong
    generic = None
    if verdict != "undecided" and truth.zeros:
        generic = oracle.generic(member, asked)
    # in a batch fewer may be left out than this member has: its verdict is its own
    words = {word, truth.verdict(generic) if generic is not None and zeros < generic else word}
    if verdict not in ("undecided", *words):
        return word, "wrong verdict"
    if verdict != "undecided":
        if generic is not None and zeros > generic:
            return word, f"{zeros} structural zeros, generically {generic}"
        if generic is not None and zeros < generic:
            word += ", fewer zeros"
            alone = oracle.case.smooth and len(oracle.branches) < 2 and oracle.implicit is None
            if alone and verdict != truth.verdict(generic):
                return word, f"{zeros} structural zeros, generically {generic}"
    return word, enclosed(truth.all(zeros), eigenvalues, radius)


def same(x: Sequence[Any], y: Sequence[Any]) -> bool:
    """Whether two members are one, to 150 bits."""
    return at_bits(
        BITS, lambda: all(abs(arb(a) - arb(b)) < arb(2) ** -150 for a, b in zip(x, y, strict=True))
    )  # type: ignore[no-any-return]


def judge(case: Case, certify: bool, asked: Sequence[dict[str, float]]) -> list[Finding]:
    """Everything that one call says, against the truth."""

    def finding(
        i: int, verdict: str, truth: str, wrong: str = "", reason: str = "", z: int = -1
    ) -> Finding:
        point_ = [asked[i]] if i >= 0 else list(asked)
        return Finding(case.kind, case.seed, point_, certify, verdict, truth, wrong, reason, z)

    oracle = Oracle(case)
    try:
        s = st.spectrum(case.family, certify=certify, **point(case, asked))
    except st.StabilityError as error:
        return [finding(-1, "refused", "", reason=str(error))]
    except Exception as error:  # any other error is the finding
        return [finding(-1, "crashed", "", f"{type(error).__name__}: {error}"[:300])]
    n = len(case.system.states)
    states = np.reshape(s.states, (-1, n))
    words = [v.word for v in np.atleast_1d(np.asarray(s.verdict, dtype=object)).ravel()]
    ways = [v.name for v in np.atleast_1d(np.asarray(s.nonlinear, dtype=object)).ravel()]
    m = s.eigenvalues.shape[-1]
    values, radii = np.reshape(s.eigenvalues, (-1, m)), np.reshape(s.radius, (-1, m))
    proved = np.atleast_1d(s.certified).ravel()
    found = []
    for i, word in enumerate(words):
        reason = s.reason if len(asked) == 1 else ""
        claim = (word, s.structural_zeros, values[i], radii[i])
        planned = oracle.nearest(asked[i], states[i])
        answers = [accept(oracle, member, exactly, claim) for member, exactly in planned]
        if all(wrong for _, wrong in answers):
            own = oracle.own_root(asked[i], states[i])
            if own is not None and not any(same(own, member) for member, _ in planned):
                answers.append(("elsewhere", oracle.elsewhere(own, asked[i], claim, certify)))
        if not answers:
            steady = word == "undecided" or oracle.rests(asked[i], states[i])
            answers = [("elsewhere", "" if steady else f"no member at {states[i]}")]
        truth, wrong = next((a for a in answers if not a[1]), answers[0])
        if not wrong and certify and word != "undecided" and not proved[i]:
            wrong = "decided, asked for a proof, and not certified"
        if (
            not wrong
            and ways[i] == "ASYMPTOTIC"
            and (word != "stable" or s.structural_zeros > case.lines)
        ):
            wrong = "asymptotic, with zeros that are no tangents"
        if not wrong and (ways[i] == "UNSTABLE") != (word == "unstable"):
            wrong = f"nonlinear {ways[i]} next to {word}"
        found.append(finding(i, word, truth, wrong, reason, s.structural_zeros))
    return found


def judge_all(case: Case) -> list[Finding]:
    """Single points and one call for all, plain and certified."""
    found = []
    for certify in (True, False):
        for one in case.asked:
            found += judge(case, certify, [one])
        if len(case.asked) > 1:
            found += judge(case, certify, case.asked)
    return found
