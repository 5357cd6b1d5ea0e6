"""Every steady state of a system in a box: what is searched, what counts, and the result."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple, overload

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..algebra.double_double import DOUBLE_DOUBLE, DoubleDouble
from ..algebra.exact.function_field import FunctionField
from ..algebra.exact.number_fields import EXACT, characteristic, vanishes
from ..algebra.exact.routh import routh
from ..algebra.intervals import INTERVALS, Interval, Tape
from ..algebra.program import Program, operations
from ..base.above import function_of
from ..base.checks import known, one_number
from ..base.citation import cited
from ..base.errors import (
    NameUnknownError,
    ParameterError,
    StabilityError,
    absent,
    listed,
    listing,
    shown,
    warned,
)
from ..base.types import Floats, Record, fields_of
from ..base.verdict import Verdict
from .equations import Equations
from .equilibrium_search import (
    MOST_BOXES,
    SearchBoxes,
    SquareSystem,
    Zeros,
    enclosed,
    search,
    within,
)
from .family import Family
from .graph.ignorable import ignorable
from .members import Anchor
from .steady import independent_rates, moving_states, rates_by_name
from .system_checks import mapping, names

TRIES = 8
"""Points of a box at which independent rates are sought."""
SHOWN = 8
"""Most equilibria that are printed."""
MOST_PARTS = 64
"""Most open parts of a box in a result; with more, the smallest box round all of them."""

DOUBLE = (
    "an equilibrium is neither proved nor excluded here: it is double, as at a fold or a branch "
    "point, or the rates have no slope or no value there, as x/(1 - exp(x)) at 0"
)
SPENT = (
    f"{MOST_BOXES} boxes were used up before all of this part was searched; give a smaller box, or "
    "ask in parts, unless equilibria form a line here"
)
BORDER = "an equilibrium lies on the border of the box or next to it, inside or outside"
GUARD = "whether {sentence} at an equilibrium here is not decided"
"""Reasons, without a full stop."""


class OpenBox(NamedTuple):
    """A part of a box in which an equilibrium is neither proved nor excluded."""

    low: dict[str, float]
    """Low end of each state."""
    high: dict[str, float]
    """High end of each state."""
    reason: str
    """Reason, in one sentence."""


SEARCHED = "each part of the box holds one of these or none, by interval arithmetic"
"""How a box was searched."""


@dataclass(frozen=True, eq=False, repr=False)
class Equilibria(Record, Sequence[dict[str, float]]):
    """Every equilibrium that a search found in a box, sorted, and the parts that it left open.

    A sequence of states by name.

    Source: docs/explanation/method.md; planted equilibria: tests/systems/test_equilibria.py.

    Examples
    --------
    >>> import casadi as ca, stability as st
    >>> x, p = ca.SX.sym("x"), ca.SX.sym("p")
    >>> s = st.System("pitchfork", x, p, p * x - x**3, states=("x",), parameters=("p",))
    >>> found = s.equilibria({"x": (-2, 2)}, p=1)
    >>> found
    <3 equilibria of pitchfork in x from -2 to 2: x = -1 (stable); x = 0 (unstable); x = 1 (stable); complete: each part of the box holds one of these or none, by interval arithmetic>
    >>> found[2]["x"], [f.name for f in found.families(at="p")]
    (1.0, ['pitchfork 1', 'pitchfork 2', 'pitchfork 3'])
    """  # noqa: E501

    system: Equations
    """The system."""
    box: Mapping[str, tuple[float, float]]
    """Ends of the states that were searched."""
    held: Mapping[str, float]
    """Values of the states that were held."""
    parameters: Mapping[str, float]
    """Values of the parameters."""
    states: Floats
    """One row for each equilibrium, all states in order, shape (N, n); 0 for states that move."""
    errors: Floats
    """Proved bounds on the errors, shape (N, n)."""
    unresolved: tuple[OpenBox, ...]
    """Parts of the box that stay open, each with a reason."""
    equations: tuple[str, ...] = ()
    """States whose rates were solved."""
    how: str = SEARCHED
    """One sentence on how the box was searched."""
    citation: str = ""
    """Keys of the works to cite, for `stability.citation`."""

    __getstate__ = fields_of

    @property
    def complete(self) -> bool:
        """Whether these are proved to be all equilibria in the closed box."""
        return not self.unresolved

    def __len__(self) -> int:
        return len(self.states)

    @overload
    def __getitem__(self, index: int) -> dict[str, float]: ...
    @overload
    def __getitem__(self, index: slice) -> list[dict[str, float]]: ...
    def __getitem__(self, index: int | slice) -> dict[str, float] | list[dict[str, float]]:
        return list(self)[index]

    def __iter__(self) -> Iterator[dict[str, float]]:
        for row in self.states:
            state = dict(zip(self.system.states, row.tolist(), strict=True))
            yield {n: v for n, v in state.items() if n in self.box or n in self.held}

    def families(self, at: str | Sequence[str]) -> list[Family]:
        """The family of steady states through each equilibrium.

        Parameters
        ----------
        at
            Name of the parameter that names a member, or several.

        Raises
        ------
        NameUnknownError
            If `at` names no parameter of the system.
        """
        where = (at,) if isinstance(at, str) else names("at", at)
        for name in where:
            known("at", name, self.system.parameters)
        others = [v for n, v in self.parameters.items() if n not in where]
        families = []
        for number, state in enumerate(self, start=1):
            unknown = {n: state[n] for n in self.box}
            anchor = Anchor(
                tuple(self.parameters[n] for n in where), tuple(others), tuple(unknown.values())
            )
            family = Family(
                self.system,
                f"{self.system.name} {number}",
                where,
                held=dict(self.held),
                unknown=unknown,
                equations=self.equations,
                typical={n: v or 1.0 for n, v in self.parameters.items()},
            )
            families.append(replace(family, anchor=None if family.closed else anchor))
        return families

    @cached_property
    def spectra(self) -> tuple[Any, ...]:
        """The spectrum at each equilibrium, or None where it has none, as at a kink."""
        first = self.system.parameters[:1]
        spectra: list[Any] = []
        for family in self.families(first):
            numbers: dict[str, Any] = {n: v for n, v in self.parameters.items() if n not in first}
            at = {"at": self.parameters[first[0]]} if first else {}
            spectra.append(None)
            with suppress(StabilityError):
                spectra[-1] = function_of("spectrum")(family, **at, parameters=numbers)
        return tuple(spectra)

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """The verdict on each equilibrium."""
        return tuple(Verdict.UNDECIDED if s is None else s.verdict for s in self.spectra)

    def __repr__(self) -> str:
        where = ", ".join(f"{n} from {a:.10g} to {b:.10g}" for n, (a, b) in self.box.items())
        held = f" with {listing(self.held, self.held.values())}" if self.held else ""
        each = [
            f"{', '.join(f'{n} = {v:.10g}' for n, v in state.items())} ({verdict.word})"
            for state, verdict in zip(self[:SHOWN], self.verdicts, strict=False)
        ]
        more = [f"{len(self) - SHOWN} more"] if len(self) > SHOWN else []
        points = f": {'; '.join([*each, *more])}" if each else ""
        state = f"complete: {self.how}" if self.complete else f"not complete, {self._first()}"
        count = f"{len(self)} equilibri{'um' if len(self) == 1 else 'a'} of {self.system.name}"
        return f"<{count} in {where}{held}{points}; {state}>"

    def _first(self) -> str:
        first, more = self.unresolved[0], len(self.unresolved) - 1
        where = ", ".join(
            f"{n} from {v:.10g} to {first.high[n]:.10g}" for n, v in first.low.items()
        )
        return f"{where}: {first.reason}" + (f" (and {more} more in .unresolved)" if more else "")

    @property
    def statement(self) -> str:
        """One sentence on how the box was searched and what was not excluded."""
        if self.complete:
            return f"every equilibrium in the box was found: {self.how}."
        return f"the search of the box is not complete; {self._first()}"

    def warn(self) -> None:
        """Issue a `StabilityWarning` where the search was not complete."""
        if not self.complete:
            warned(self.statement)


# --- what is asked ---


class _Question(NamedTuple):
    """A box and what its equilibria are in it."""

    system: Equations
    unknown: tuple[str, ...]
    low: Floats
    high: Floats
    held: dict[str, float]
    parameters: dict[str, float]
    solved: tuple[str, ...]
    """Names of the rates that are solved."""
    square: SquareSystem
    """These rates; held states count as further parameters."""
    others: ca.SX
    """Rates that have to vanish too."""

    @property
    def numbers(self) -> list[float]:
        """Parameters of the square system."""
        return [*self.parameters.values(), *self.held.values()]


def equilibria(system: Equations, box: Mapping[str, Any], parameters: dict[str, Any]) -> Equilibria:
    """Every steady state in a box; see `System.equilibria`.

    Parameters
    ----------
    system
        The equations of motion.
    box, parameters
        As in `System.equilibria`.
    """
    asked = _asked(system, box, parameters)
    zeros = search(asked.square, asked.low[None], asked.high[None], np.array([asked.numbers]))
    rows, open_ = _judged(asked, zeros)
    states, errors = np.zeros((2, len(rows), len(system.states)))
    where = [system.index(n) for n in asked.unknown]
    x, error = zeros.x[rows], np.abs(zeros.rest[rows]) + 1.01 * zeros.error[rows]
    near = np.abs(x) <= error  # zero is as good a value
    states[:, where], errors[:, where] = np.where(near, 0.0, x), error + near * np.abs(x)
    for name, value in asked.held.items():
        states[:, system.index(name)] = value
    # the search may go beyond the box by a little
    low, high = np.maximum(zeros.open.lo, asked.low), np.minimum(zeros.open.hi, asked.high)
    left = _merged(zeros.open[np.asarray((low <= high).all(axis=1))])
    reason = SPENT if zeros.spent.any() else DOUBLE
    open_ += [
        (np.maximum(a, asked.low), np.minimum(b, asked.high), reason)
        for a, b in zip(left.lo, left.hi, strict=True)
    ]

    def by_name(values: Floats) -> dict[str, float]:
        return dict(zip(asked.unknown, values.tolist(), strict=True))

    unresolved = tuple(OpenBox(by_name(a), by_name(b), reason) for a, b, reason in open_)
    result = Equilibria(
        system,
        {n: (a, by_name(asked.high)[n]) for n, a in by_name(asked.low).items()},
        asked.held,
        asked.parameters,
        states,
        errors,
        unresolved,
        asked.solved,
        how="; ".join(filter(None, [SEARCHED, system.approximation])),
        citation=cited(system=system.name, model=bool(system.quantities), proofs=True),
    )
    result.warn()
    return result


MOST_OF_EACH = 10_000
"""Most boxes of a search that is one of many."""
MOST_STATES = 8
"""Most states whose polynomial is formed in two doubles."""


class Counts(NamedTuple):
    """Numbers of equilibria in a box, one for each row of parameters; -1 where not proved."""

    equilibria: NDArray[np.int16]
    stable: NDArray[np.int16]
    """Those whose eigenvalues all have negative real parts; -1 where a zero is one by structure."""


def counts(system: Equations, box: Mapping[str, Any], numbers: Mapping[str, Floats]) -> Counts:
    """Numbers of equilibria in a box for many parameters.

    Parameters
    ----------
    system
        The equations of motion.
    box
        (low, high) of each state that is sought.
    numbers
        Values of the parameters, and of states that are held, each of shape (N,).
    """
    middle = {n: float(v[len(v) // 2]) for n, v in numbers.items()}
    held = {n: v for n, v in middle.items() if n not in system.parameters}
    asked = _asked(system, {**box, **held}, {n: v for n, v in middle.items() if n not in held})
    rows = np.stack([numbers[n] for n in (*asked.parameters, *asked.held)], axis=1)
    low, high = (np.tile(v, (len(rows), 1)) for v in (asked.low, asked.high))
    zeros = search(asked.square, low, high, rows, MOST_OF_EACH)
    owner = zeros.boxes.owner
    signs, tape = _enclosed_signs(asked, *_ends_of(zeros, slice(None)), list(rows[owner].T))
    inside = within(zeros.x, np.abs(zeros.rest) + zeros.error, asked.low, asked.high)
    inside &= ~np.asarray(tape.part) & (not asked.others.numel())
    for value in signs:
        inside &= value.lo > 0
    complete = ~zeros.spent
    reached = ((zeros.open.lo <= asked.high) & (zeros.open.hi >= asked.low)).all(axis=1)
    complete[zeros.open.owner[reached]] = False
    for k in np.flatnonzero(~inside).tolist():
        named = dict(zip((*asked.parameters, *asked.held), rows[owner[k]].tolist(), strict=True))
        single = asked._replace(
            parameters={n: named[n] for n in asked.parameters},
            held={n: named[n] for n in asked.held},
        )
        judged = _judged_alone(single, zeros, k)
        inside[k] = judged is True
        complete[owner[k]] &= judged in (True, False)
    decays, grows = _decaying(asked, zeros, rows[owner])

    def number(rows_: NDArray[np.bool_], sure: NDArray[np.bool_]) -> NDArray[np.int16]:
        count = np.bincount(owner[rows_], minlength=len(rows))
        return np.where(sure, count, -1).astype(np.int16)

    decided = complete.copy()
    decided[owner[inside & ~decays & ~grows]] = False
    return Counts(number(inside, complete), number(inside & decays, decided))


@np.errstate(all="ignore")
def _decaying(
    asked: _Question, zeros: Zeros, numbers: Floats
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether all eigenvalues at zeros are proved to have negative real parts; whether some not."""
    system, none = asked.system, np.zeros(len(zeros.x), dtype=bool)
    kept = [i for i, n in enumerate(system.states) if n in (*asked.unknown, *asked.held)]
    if len(kept) > MOST_STATES or not len(none):
        return none, none
    # no rate depends on the other states
    matrix = ca.jacobian(system.rhs[kept], system.x)[:, kept]
    program = Program(ca.Function("matrix", [asked.square.x, asked.square.p], [matrix]))
    x = [DoubleDouble(*v) for v in zip(zeros.x.T, zeros.rest.T, zeros.error.T, strict=True)]
    parameters = [DoubleDouble(v) for v in numbers.T]
    polynomial = characteristic(program.dense(DOUBLE_DOUBLE, [x, parameters], zero=0))
    decays, grows = ~none, none
    for c in polynomial:
        bound = c.hi + np.abs(c.lo) + 1.01 * c.error if isinstance(c, DoubleDouble) else c
        grows = grows | (bound <= 0)
    vanishing = [not isinstance(c, DoubleDouble) and c == 0 for c in polynomial]
    if vanishing[0]:  # a zero by structure says nothing of the others
        return none, none
    if any(vanishing):
        return none, ~none
    for value in list(routh(polynomial))[1:]:
        sign = value.sign() if isinstance(value, DoubleDouble) else np.sign(value)
        grows = grows | (decays & (sign < 0))
        decays = decays & (sign > 0)
    return decays, grows


def _asked(system: Equations, box: Mapping[str, Any], parameters: dict[str, Any]) -> _Question:
    """The question, checked."""
    bounds = mapping("box", box)
    for name in parameters:
        known("parameter", name, system.parameters)
    missing = [n for n in system.parameters if n not in parameters]
    if missing:
        raise ParameterError(f"{absent(missing)}; give a number for each of the parameters.")
    numbers = {n: one_number(n, parameters[n]) for n in system.parameters}
    held, ends = {}, {}
    for name, value in bounds.items():
        if name not in system.states:
            raise NameUnknownError(
                f"box names {shown(name)}, which is no state; states are "
                f"{', '.join(system.states)}."
            )
        if np.ndim(value) == 0:
            held[name] = one_number(f"box {name}", value)
        else:
            ends[name] = box_ends(name, value)
    unknown = tuple(n for n in system.states if n in ends)
    moving = moving_states(system, set(bounds))
    absent_ = [n for n in system.states if n not in bounds and n not in moving]
    if absent_:
        raise ParameterError(
            f"box lacks {listed(absent_)}; give (low, high), or a number at which a state is held."
        )
    free = [n for n in unknown if n in ignorable(system)]
    if free:
        raise ParameterError(
            f"no other rate depends on {listed(free)}, so a steady motion has any value of it; "
            "leave it out of the box, and it may move."
        )
    if not unknown:
        raise ParameterError("box has no state with a low and a high end; give (low, high).")
    low, high = np.array([ends[n] for n in unknown]).T
    _refuse_jumps(system)
    solved = _solved(system, held, ends, numbers, moving)
    table = rates_by_name(system)
    rates = ca.vertcat(*[table[n] for n in solved])
    symbol = {n: system.x[system.index(n)] for n in system.states}
    x = ca.vertcat(*[symbol[n] for n in unknown])
    p = ca.vertcat(system.p, *[symbol[n] for n in held])
    still = [system.x[i] for i, n in enumerate(system.states) if n not in bounds]
    rates = ca.substitute(rates, ca.vertcat(*still), ca.SX.zeros(len(still))) if still else rates
    others = [n for n in system.states if n not in solved and n not in moving]
    rest = ca.vertcat(*[table[n] for n in others])
    square = SquareSystem(x, p, ca.SX(rates))
    return _Question(system, unknown, low, high, held, numbers, solved, square, ca.SX(rest))


def box_ends(name: str, value: Any) -> tuple[float, float]:
    """Low and high end of a state, checked."""
    if np.shape(value) != (2,):
        raise ParameterError(f"box {name} is {shown(value)}; give (low, high), or one number.")
    low, high = (one_number(f"box {name}", v) for v in value)
    if not low < high:
        raise ParameterError(
            f"box {name} from {low:g} to {high:g} is empty; give (low, high) with low < high, or "
            "one number."
        )
    return low, high


def _solved(
    system: Equations,
    held: Mapping[str, float],
    ends: Mapping[str, tuple[float, float]],
    numbers: Mapping[str, float],
    moving: Sequence[str],
) -> tuple[str, ...]:
    """As many independent rates as unknowns, at a point of the box where rates have values."""
    rng = np.random.default_rng(9)
    unknown = tuple(n for n in system.states if n in ends)
    refusal: ParameterError | None = None
    for _ in range(TRIES):
        share = rng.uniform()
        point = {n: a + (b - a) * share for n, (a, b) in ends.items()}
        try:
            return independent_rates(system, held, unknown, point | dict(numbers), moving)
        except ParameterError as error:
            refusal = refusal or error
    if kept := conserved_sum(system):
        raise ParameterError(
            f"{kept} is constant in every motion of {system.name}, so equilibria form lines; put "
            "one of these states into the rates by the others and its total, a parameter."
        )
    assert refusal is not None
    raise refusal


def _refuse_jumps(system: Equations) -> None:
    graph = ca.Function("rates", [system.x, system.p], [system.rhs])
    if ca.OP_SIGN in operations(graph):
        raise ParameterError(
            f"the rates of {system.name} hold a sign, a maximum or a branch; ask on each side of "
            "its switch, with a number in place of the sign."
        )


def conserved_sum(system: Equations) -> str:
    """A sum of states, with small whole weights, that is proved to be constant; or nothing."""
    graph = ca.Function("rates", [system.x, system.p], [ca.densify(system.rhs)])
    rng = np.random.default_rng(3)
    n, m = len(system.states), len(system.parameters)
    points = rng.uniform(0.5, 1.5, (2 * n + 2, n + m))
    rates = np.array([np.array(graph(v[:n], v[n:])).ravel() for v in points])
    if not np.isfinite(rates).all():
        return ""
    _, sizes, ways = np.linalg.svd(rates)
    null = ways[np.append(sizes, np.zeros(n))[:n] <= 1e-12 * max(float(sizes[0]), 1e-300)]
    rows = np.abs(null)
    for row in null[np.argsort((rows > 1e-9).sum(axis=1))]:
        weights = [Fraction(v / row[np.abs(row).argmax()]).limit_denominator(100) for v in row]
        field_ = FunctionField([*system.states, *system.parameters])
        with suppress(ArithmeticError, StabilityError):
            symbols = field_.symbols
            values = Program(graph).run(field_.algebra, [symbols[:n], symbols[n:]])[0]
            terms = [
                v * EXACT.constant(1.0) * w.numerator / w.denominator
                for v, w in zip(values, weights, strict=True)
                if w
            ]
            if vanishes(sum(terms[1:], terms[0])):
                return " + ".join(
                    s if w == 1 else f"{w} {s}"
                    for s, w in zip(system.states, weights, strict=True)
                    if w
                ).replace("+ -", "- ")
    return ""


# --- what counts ---

_Part = tuple[Floats, Floats, str]
"""Ends of an open part, and the reason."""


def _judged(asked: _Question, zeros: Zeros) -> tuple[list[int], list[_Part]]:
    """Rows of the zeros that are equilibria in the closed box, and those that may be."""
    rows: list[int] = []
    open_: list[_Part] = []
    for k in range(len(zeros.x)):
        counts = _judged_alone(asked, zeros, k)
        if isinstance(counts, str):
            low, high = _ends_of(zeros, k)
            part = np.maximum(low, asked.low), np.minimum(high, asked.high)
            open_.append((*part, counts))
        elif counts:
            rows.append(k)
    return rows, open_


def _judged_alone(asked: _Question, zeros: Zeros, k: int) -> bool | str:
    """Whether a zero is an equilibrium in the closed box; a reason where this is open."""
    counts = _counts(asked, zeros, k)
    if isinstance(counts, str) and _exact(asked, zeros, k):
        zeros.rest[k] = zeros.error[k] = 0.0
        counts = _counts(asked, zeros, k)
    return counts


def _ends_of(zeros: Zeros, k: int | slice) -> tuple[Floats, Floats]:
    """Low and high ends of zeros, as doubles."""
    x, radius = zeros.x[k], np.abs(zeros.rest[k]) + zeros.error[k]
    none = ~radius.any(axis=-1, keepdims=True)
    low, high = np.nextafter(x - radius, -np.inf), np.nextafter(x + radius, np.inf)
    return np.where(none, x, low), np.where(none, x, high)


def _counts(asked: _Question, zeros: Zeros, k: int) -> bool | str:
    """Whether a zero is an equilibrium in the box; a reason where this is open."""
    # next to an end the difference is exact
    above = (zeros.x[k] - asked.low) + zeros.rest[k]
    below = (asked.high - zeros.x[k]) - zeros.rest[k]
    error = 1.01 * zeros.error[k] + 2.0**-100 * np.abs(zeros.rest[k])
    if (above < -error).any() or (below < -error).any():
        return False
    border = (above < error) | (below < error)
    signs = _signs(asked, *_ends_of(zeros, k))
    if signs is not False and border.any() and not _on_border(asked, zeros, k, border):
        return BORDER
    return signs


def _exact(asked: _Question, zeros: Zeros, k: int) -> bool:
    """Whether the double is the zero, by exact numbers."""
    point = dict(enumerate(zeros.x[k].tolist()))
    return all(_zero_rows(asked, asked.square.rates, point))


def _signs(asked: _Question, low: Floats, high: Floats) -> bool | str:
    """Whether conditions hold at a zero and the other rates vanish; a reason where it is open."""
    system, conditions = asked.system, asked.system.conditions
    outputs, tape = _enclosed_signs(asked, low[None], high[None], asked.numbers)
    ends = [(float(np.max(v.lo)), float(np.min(v.hi))) for v in outputs]
    for condition, (a, b) in zip(conditions, ends, strict=False):
        if b <= 0:
            return False
        if not a > 0 or np.any(tape.part):
            words = condition.sentence.replace("{", "").replace("}", "").split(" is ")[0]
            return GUARD.format(sentence=f"{words or 'a condition'} is positive")
    names_ = [n for n in system.states if n not in asked.solved]
    for name, (a, b) in zip(names_, ends[len(conditions) :], strict=False):
        if a > 0 or b < 0:
            return False
        exact = dict(enumerate(low.tolist())) if (low == high).all() else {}
        if not all(_zero_rows(asked, asked.others, exact)):
            return f"whether the rate of {name} vanishes at an equilibrium of the others is open"
    return True


def _enclosed_signs(
    asked: _Question, low: Floats, high: Floats, numbers: Sequence[Any]
) -> tuple[list[Interval], Tape]:
    """Conditions and the rates that are not solved, over boxes, and the marks."""
    values = ca.vertcat(*[c.value for c in asked.system.conditions], asked.others)
    tape = Tape(recording=False)
    if not values.numel():
        return [], tape
    program = Program(ca.Function("signs", [asked.square.x, asked.square.p], [ca.densify(values)]))
    x = [Interval(a, b, tape) for a, b in zip(low.T.copy(), high.T.copy(), strict=True)]
    with np.errstate(all="ignore"):
        outputs = program.run(INTERVALS, [x, [Interval(v, v) for v in numbers]])[0]
    return [_interval(v) for v in outputs], tape


def _interval(value: Any) -> Interval:
    return value if isinstance(value, Interval) else Interval(value, value)


def _zero_rows(asked: _Question, rates: ca.SX, fixed: Mapping[int, float]) -> list[bool]:
    """Which rates are zero, for all numbers, where some unknowns have fixed values."""
    x, p = asked.square.x, asked.square.p
    program = Program(ca.Function("rates", [x, p], [ca.densify(rates)]))
    field_ = FunctionField(asked.unknown)
    try:
        unknown = [
            EXACT.constant(fixed[i]) if i in fixed else s for i, s in enumerate(field_.symbols)
        ]
        values = program.run(field_.algebra, [unknown, [EXACT.constant(v) for v in asked.numbers]])[
            0
        ]
        return [vanishes(v) for v in values]
    except (ArithmeticError, StabilityError):
        return [False] * rates.numel()


def _on_border(asked: _Question, zeros: Zeros, k: int, border: Any) -> bool:
    """Whether a zero is on the border by proof: rates that are not zero on it have a zero there."""
    x, n = zeros.x[k], len(asked.unknown)
    ends = np.where(x - asked.low < asked.high - x, asked.low, asked.high)
    fixed = {int(i): float(ends[i]) for i in np.flatnonzero(border)}
    zero = _zero_rows(asked, asked.square.rates, fixed)
    left = [i for i in range(n) if i not in fixed]
    rows = [i for i in range(n) if not zero[i]]
    if len(rows) != len(left):
        return False
    at, error = np.array([fixed.get(i, x[i]) for i in range(n)]), np.zeros(n)
    if left:
        symbols, rates = asked.square.x, asked.square.rates
        numbers = ca.vertcat(asked.square.p, *[symbols[i] for i in fixed])
        face = SquareSystem(symbols[left], numbers, ca.SX(rates[rows]))
        values = np.array([[*asked.numbers, *fixed.values()]])
        at[left], rest, error[left] = (v[0] for v in enclosed(face, at[None, left], values))
        error[left] += np.abs(rest)
    # the only zero there is in the box of the proof
    return bool(within(at, error, zeros.boxes.lo[k], zeros.boxes.hi[k]))


def _merged(boxes: SearchBoxes) -> SearchBoxes:
    """Boxes round those that touch."""
    lo, hi = boxes.lo, boxes.hi
    room = 1e-12 * (hi - lo).max(axis=0, initial=0.0) if len(lo) else 0.0
    while len(lo) > 1:
        order = np.lexsort(lo.T[::-1])
        parts: list[tuple[Floats, Floats]] = []
        for a, b in zip(lo[order], hi[order], strict=True):
            for i in range(len(parts) - 1, max(len(parts) - MOST_PARTS, 0) - 1, -1):
                if (a <= parts[i][1] + room).all() and (b >= parts[i][0] - room).all():
                    parts[i] = np.minimum(a, parts[i][0]), np.maximum(b, parts[i][1])
                    break
            else:
                parts.append((a, b))
        done = len(parts) == len(lo)
        lo, hi = np.array([a for a, _ in parts]), np.array([b for _, b in parts])
        if done:
            break
    if len(lo) > MOST_PARTS:
        lo, hi = lo.min(axis=0, keepdims=True), hi.max(axis=0, keepdims=True)
    return SearchBoxes(lo, hi, np.zeros(len(lo), dtype=np.intp))
