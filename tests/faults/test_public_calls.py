"""Every public function, constructor and method refuses words that do not fit in a sentence."""

from __future__ import annotations

import inspect
import math
import pickle
import timeit
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from typing import Any

import casadi as ca
import matplotlib.pyplot as plt
import numpy as np
import pytest

import stability as st
from stability.base.calls import guarded
from stability.base.lazy import HOMES

OTHERS = {"REAL_DISKS", "UPRIGHT", "StabilityError", "StabilityWarning"}
"""Public names that are no functions or classes of the package, or errors, which take anything."""
UNKNOWN = "no_such_word"


def calls() -> Iterator[tuple[str, Any, Any, int]]:
    """Public callables: name, function, its signature, and how many words are the instance's."""
    for public in sorted(set(HOMES) - OTHERS):
        value = getattr(st, public)
        if not isinstance(value, type):
            yield public, value, inspect.signature(value), 0
            continue
        if not issubclass(value, Enum):
            yield public, value, inspect.signature(value), 0
        for name in dir(value):
            entry = inspect.getattr_static(value, name)
            kind = getattr(entry, "__func__", entry)
            if name[0] == "_" or not inspect.isfunction(kind) or issubclass(value, Enum):
                continue
            if not kind.__module__.startswith("stability"):
                continue  # of a base that is Python's own
            bound = isinstance(entry, (classmethod, staticmethod))
            yield (
                f"{public}.{name}",
                getattr(value, name),
                inspect.signature(getattr(value, name)),
                int(not bound),
            )


CALLS = {name: rest for name, *rest in calls()}


def sentence(caught: pytest.ExceptionInfo[st.StabilityError]) -> str:
    said = str(caught.value)
    assert len(said.splitlines()) == 1 and len(said) <= 280 and said.endswith((".", "…"))
    return said


def test_every_public_name_is_called_here() -> None:
    assert {n.split(".")[0] for n in CALLS} | OTHERS >= {
        n for n in HOMES if not (isinstance(v := getattr(st, n), type) and issubclass(v, Enum))
    }
    assert len(CALLS) > 150


@pytest.mark.parametrize("name", CALLS)
def test_words_that_do_not_fit_are_refused(name: str) -> None:
    function, signature, own = CALLS[name]
    kinds = [p.kind for p in signature.parameters.values()]
    this = [None] * own
    if inspect.Parameter.VAR_KEYWORD not in kinds:
        with pytest.raises(st.StabilityError) as caught:
            function(*this, **{UNKNOWN: 1})
        assert UNKNOWN in sentence(caught)
    if inspect.Parameter.VAR_POSITIONAL not in kinds:
        with pytest.raises(st.StabilityError) as caught:
            function(*this, *range(40))
        said = sentence(caught)
        assert f"{40} are given" in said or f"{40 - own} are given" in said
    lacking = [
        n
        for n, p in list(signature.parameters.items())[own:]
        if p.default is p.empty and p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)
    ]
    if lacking:
        with pytest.raises(st.StabilityError) as caught:
            function(*this)
        assert lacking[0] in sentence(caught)
        first, *rest = lacking
        if signature.parameters[first].kind is inspect.Parameter.POSITIONAL_OR_KEYWORD:
            with pytest.raises(st.StabilityError) as caught:
                function(*this, 1, **{first: 1}, **dict.fromkeys(rest, 1))
            assert f"{first} twice" in sentence(caught)


@pytest.mark.parametrize("name", ["Verdict", "Outcome", "Crossing", "HopfKind", "Nonlinear"])
@pytest.mark.parametrize("words", [(), ("stable", "unstable"), (None,), ({},), (1j,)])
def test_a_word_of_an_enumeration_is_one(name: str, words: Any) -> None:
    with pytest.raises(st.StabilityError):
        getattr(st, name)(*words)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: st.spectrum(st.Disk(), "rolling"),
            "spectrum takes 1 argument without a name, and 2 are given; without names it takes "
            "family; name the others: at, lean,",
        ),
        (lambda: st.Scene(resistence=3), "Scene has no argument 'resistence'"),  # type: ignore[call-arg]
        (lambda: st.basins(contact="viscous"), "horizon is missing in a call of basins;"),  # type: ignore[call-arg]
        (lambda: st.Viscous(0.3, mu=0.3), "Viscous has mu twice, once without its name"),  # type: ignore[misc]
        (lambda: st.Disk(mas=1), "Disk has no argument 'mas'; do you mean mass; it takes mass,"),  # type: ignore[call-arg]
        (lambda: st.Disk.hoop(3), "Disk.hoop takes no arguments without a name, and 1 is given"),  # type: ignore[call-arg]
    ],
)
def test_the_sentence_names_the_word_and_what_is_accepted(call: Any, said: str) -> None:
    with pytest.raises(st.StabilityError) as caught:
        call()
    assert sentence(caught).startswith(said)


def test_a_guard_keeps_what_a_user_sees_of_a_function() -> None:
    assert str(inspect.signature(st.wilson)).startswith("(count: ")
    assert (st.wilson.__doc__ or "").startswith("Wilson")
    assert pickle.loads(pickle.dumps(st.wilson)) is st.wilson
    assert inspect.signature(st.Scene).parameters["tolerance"].default == 1e-6


def test_an_error_within_a_call_that_fits_is_kept() -> None:
    def inner(a: int) -> None:
        raise TypeError("of the user's own code" * bool(a))

    with pytest.raises(TypeError, match="of the user's own code"):
        guarded(inner, "inner")(1)


def test_a_guard_costs_less_than_five_microseconds() -> None:
    def nothing(a: int, *, b: int = 0) -> None:
        pass

    kept = guarded(nothing, "nothing")
    bare, over = (
        min(timeit.repeat(lambda f=f: f(1, b=2), number=2000, repeat=9)) / 2000
        for f in (nothing, kept)
    )
    assert over - bare < 5e-6


# --- values of the wrong type ---


class Refuses:
    """A value that raises on every question."""

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise RuntimeError("no array")

    def __bool__(self) -> bool:
        raise RuntimeError("no truth")

    def __eq__(self, other: object) -> bool:
        raise RuntimeError("no equality")

    __hash__ = None  # type: ignore[assignment]


ODD: dict[str, Any] = {
    "None": None,
    "True": True,
    "0.5": 0.5,
    "-1": -1,
    "nan": math.nan,
    "inf": math.inf,
    "10**400": 10**400,
    "1j": 1j,
    "a word": "rolling",
    "{}": {},
    "a mapping": {1: None, "b": [1]},
    "[]": [],
    "ragged": [[1], [2, 3]],
    "texts": np.array(["a"]),
    "complex": np.array([1j, 2.0]),
    "object": object(),
    "class": dict,
    "refuses": Refuses(),
}


def pendulum() -> Any:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    names = {"states": ("angle", "rate"), "parameters": ("g", "d")}
    s = st.System("pendulum", x, p, ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - p[1] * x[1]), **names)
    return st.Family(s, "hanging", at=("g",), held={"angle": 0, "rate": 0})


LAW = st.Viscous(0.3)
SMALL: dict[str, Any] = {"contact": "viscous", "mu": 0.3, "horizon": 1.0}
FITTING: dict[str, Any] = {
    "Torus": lambda: ((0.2,), {"solid": True, "mass": 1.0}),
    "AirTorque": lambda: ((0.1,), {}),
    "Ball": lambda: (({"a": 0.0}, {"a": 1.0}), {}),
    "Scene": lambda: (
        (),
        {
            "disk": st.Disk(),
            "contact": LAW,
            "start": {"theta": 1.2},
            "horizon": 1.0,
            "quantities": ("final",),
            "uncertain": {},
        },
    ),
    "Family": lambda: (
        (pendulum().system, "h"),
        {
            "at": ("g",),
            "held": {"angle": 0, "rate": 0},
            "unknown": {},
            "equations": (),
            "positive": (),
            "typical": {},
        },
    ),
    "c_code": lambda: ((pendulum(),), {"out": "code", "name": "c"}),
    "latex": lambda: ((pendulum(),), {"d": 0.1, "positive": ()}),
    "conditions": lambda: ((pendulum(),), {"d": 0.1, "positive": (), "between": {}}),
    "wilson": lambda: ((3, 10), {"level": 0.9}),
    "fractions": lambda: ((np.array([1, 2, 1]),), {"level": 0.9}),
    "launch_labels": lambda: ((), {"varied": ("omega3", "theta"), **SMALL}),
    "spectrum": lambda: (("rolling",), {"at": 1.2, "contact": LAW, "body": st.Torus(0.2)}),
    "boundaries": lambda: (("rolling",), {"axis": ("at", 0.5, 2, 5), "contact": LAW}),
    "table": lambda: (("families",), {"positive": (), "decimals": None}),
    "plot_map": lambda: (
        (st.stability_map("spinning", x=("at", 1, 4, 3), y=("mu", 0.1, 2, 3)),),
        {"title": "t", "above": None, "points": None, "ax": None},
    ),
    "plot_locus": lambda: (
        (st.spectrum("rolling", at=1.2, contact=LAW),),
        {"unit": "", "title": "", "ax": None, "thresholds": ()},
    ),
    "simulate": lambda: (
        (st.Torus(0.2), LAW, {"theta": 1.2}, 0.1),
        {"check": False, "resistance": st.AirTorque(0.1)},
    ),
    "basins": lambda: (
        (),
        {"x": ("omega3", 1, 3, 2), "y": ("theta", 1.2, 1.5, 2), "chunk": 2, "store": None, **SMALL},
    ),
}


@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=pytest.mark.long) if n in ("plot_map", "plot_locus", "table") else n
        for n in FITTING
    ],
)
def test_a_value_of_another_type_is_refused_or_taken(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One argument at a time: no error but the package's own."""
    monkeypatch.chdir(tmp_path)
    given, named = FITTING[name]()
    function, refused = getattr(st, name), 0
    for word, value in ODD.items():
        for place in (*range(len(given)), *named):
            few, more = list(given), dict(named)
            if isinstance(place, int):
                few[place] = value
            else:
                more[place] = value
            try:
                function(*few, **more)
            except st.StabilityError as error:
                assert len(str(error).splitlines()) == 1
                refused += 1
            except Exception as error:
                raise AssertionError(f"{name} with {place} = {word}: {error!r}") from error
            plt.close("all")
    assert refused > len(ODD) / 2


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: st.wilson([[1], [2, 3]], 3), "count is [[1], [2, 3]]; give numbers."),
        (lambda: st.table([]), "name is []; give a text."),  # type: ignore[arg-type]
        (
            lambda: st.plot_locus(st.spectrum("rolling", at=1.2, contact=LAW), ax=[[1], [2, 3]]),
            "ax is [[1], [2, 3]]; give axes of Matplotlib.",
        ),
        (lambda: st.latex(pendulum(), d=0.1, positive=0.5), "positive is 0.5; give"),  # type: ignore[arg-type]
    ],
)
def test_the_sentence_names_the_value_and_its_type(call: Any, said: str) -> None:
    with pytest.raises(st.StabilityError) as caught:
        call()
    assert sentence(caught).startswith(said)
