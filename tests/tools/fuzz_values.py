"""Odd values for the fuzzer of calls, each with a word for it."""

from __future__ import annotations

import datetime
import decimal
import random
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import sympy
import xarray as xr

import stability as st

SHORT = ("StabilityError",)
"""Calls whose result is only made, not looked at."""


class _Refuses:
    """An object that raises on every question."""

    def __repr__(self) -> str:
        raise RuntimeError("no repr")

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise RuntimeError("no array")

    def __float__(self) -> float:
        raise RuntimeError("no float")

    def __eq__(self, other: object) -> bool:
        raise RuntimeError("no equality")

    def __hash__(self) -> int:
        return 1

    def __bool__(self) -> bool:
        raise RuntimeError("no truth")


class _Words(str):
    """A kind of string."""


class _Long:
    def __repr__(self) -> str:
        return "line\n" * 500


def _loop() -> list[Any]:
    value: list[Any] = [1.0]
    value.append(value)
    return value


def _deep() -> Any:
    value: Any = 0.5
    for _ in range(200):
        value = [value]
    return value


def _read_only() -> Any:
    value = np.array([0.5, 0.7])
    value.flags.writeable = False
    return value


def _raises(*_: Any) -> None:
    raise_(ZeroDivisionError("the user's own"))


def raise_(error: Exception) -> None:
    """A statement as an expression."""
    raise error


VALUES: dict[str, Callable[[], Any]] = {
    "None": lambda: None,
    "True": lambda: True,
    "False": lambda: False,
    "0": lambda: 0,
    "-0.0": lambda: -0.0,
    "1": lambda: 1,
    "-1": lambda: -1,
    "2": lambda: 2,
    "0.5": lambda: 0.5,
    "3.7": lambda: 3.7,
    "1e308": lambda: 1e308,
    "-1e308": lambda: -1e308,
    "5e-324": lambda: 5e-324,
    "1e-310": lambda: 1e-310,
    "1e-12": lambda: 1e-12,
    "1e12": lambda: 1e12,
    "nan": lambda: np.nan,
    "inf": lambda: np.inf,
    "-inf": lambda: -np.inf,
    "10**400": lambda: 10**400,
    "10**5000": lambda: 10**5000,
    "2**64-1": lambda: 2**64 - 1,
    "10**9": lambda: 10**9,
    "-10**9": lambda: -(10**9),
    "1j": lambda: 1j,
    "0.5+0j": lambda: 0.5 + 0j,
    "''": lambda: "",
    "rolling": lambda: "rolling",
    "'0.3'": lambda: "0.3",
    "5000 letters": lambda: "a" * 5000,
    "surrogate": lambda: "\udcff",
    "lines": lambda: "a\nb\nc\nd",
    "NUL": lambda: "a\0b",
    "escape": lambda: "\x1b[31m",
    "right to left": lambda: "\u202eabc",
    "braces": lambda: "{value}",
    "bytes": lambda: b"x" * 100,
    "bytearray": lambda: bytearray(b"12"),
    "[]": list,
    "()": tuple,
    "{}": dict,
    "set": lambda: {1.0, 2.0},
    "[1,2,3]": lambda: [1, 2, 3],
    "ragged": lambda: [[1], [2, 3]],
    "[None]": lambda: [None],
    "['a']": lambda: ["a"],
    "['0.3', 1]": lambda: ["0.3", 1.0],
    "[True, 0.5]": lambda: [True, 0.5],
    "mapping": lambda: {"theta": 1.4},
    "odd mapping": lambda: {1: None, "b": [1]},
    "big list": lambda: [0.5] * 100_000,
    "loop": _loop,
    "deep": _deep,
    "range": lambda: range(3),
    "iterator": lambda: iter([1.0]),
    "generator": lambda: (i for i in range(3)),
    "empty array": lambda: np.array([]),
    "0-d": lambda: np.array(0.5),
    "(0, 3)": lambda: np.zeros((0, 3)),
    "(2, 3)": lambda: np.ones((2, 3)),
    "(1, 1, 1, 1)": lambda: np.ones((1, 1, 1, 1)),
    "(7,)": lambda: np.arange(7.0) + 0.1,
    "with nan": lambda: np.array([np.nan, 1.0]),
    "object array": lambda: np.array([0.5, None]),
    "object array of numbers": lambda: np.array([0.5, 1], dtype=object),
    "string array": lambda: np.array(["a"]),
    "numpy string": lambda: np.str_("rolling"),
    "datetime64": lambda: np.datetime64("2020-01-01"),
    "date": lambda: datetime.date(2020, 1, 1),
    "timedelta": lambda: datetime.timedelta(1),
    "Fraction": lambda: Fraction(1, 3),
    "huge Fraction": lambda: Fraction(10**400, 3),
    "Decimal": lambda: decimal.Decimal("0.3"),
    "Decimal NaN": lambda: decimal.Decimal("NaN"),
    "Decimal sNaN": lambda: decimal.Decimal("sNaN"),
    "float16": lambda: np.float16(0.5),
    "float32": lambda: np.float32(0.3),
    "longdouble": lambda: np.longdouble("0.3"),
    "huge longdouble": lambda: np.longdouble("1e4000"),
    "int8": lambda: np.int8(1),
    "uint64": lambda: np.uint64(2**64 - 1),
    "np.bool": lambda: np.True_,
    "masked": lambda: np.ma.masked,
    "masked array": lambda: np.ma.array([0.5, 0.7], mask=[0, 1]),
    "unmasked": lambda: np.ma.array([0.5, 0.7]),
    "matrix": lambda: np.asmatrix([[0.5, 0.7]]),
    "complex array": lambda: np.array([1j, 2.0]),
    "read-only": _read_only,
    "strided": lambda: np.linspace(0.1, 1, 9)[::-2],
    "swapped": lambda: np.array([0.5], ">f8"),
    "records": lambda: np.zeros(2, dtype=[("a", float)]),
    "DataArray": lambda: xr.DataArray(0.5),
    "long DataArray": lambda: xr.DataArray(np.linspace(0.1, 1, 3), dims="a"),
    "Dataset": lambda: xr.Dataset({"a": ("t", np.zeros(1000))}),
    "DM": lambda: ca.DM(0.5),
    "DM vector": lambda: ca.DM([0.5, 0.7]),
    "sparse DM": lambda: ca.DM(2, 2),
    "SX": lambda: ca.SX.sym("q"),
    "SX matrix": lambda: ca.SX.sym("q", 3, 3),
    "SX number": lambda: ca.SX(0.5),
    "MX": lambda: ca.MX.sym("q"),
    "long SX": lambda: ca.SX.sym("q", 300),
    "Function": lambda: ca.Function("f", [s := ca.SX.sym("s")], [s]),
    "Rational": lambda: sympy.Rational(1, 3),
    "Symbol": lambda: sympy.Symbol("s"),
    "path": lambda: Path("missing") / "x.nc",
    "module": lambda: np,
    "class": lambda: dict,
    "object": object,
    "error": lambda: ValueError("x"),
    "function": lambda: len,
    "lambda": lambda: lambda *_: None,
    "raises": lambda: _raises,
    "refuses": _Refuses,
    "long repr": _Long,
    "kind of string": lambda: _Words("rolling"),
    "Disk": st.Disk,
    "array Disk": lambda: st.Disk(k=np.linspace(0.1, 0.5, 4)),
    "Viscous": lambda: st.Viscous(0.3),
    "array Viscous": lambda: st.Viscous([0.3, 0.4, 0.5]),
    "the class Viscous": lambda: st.Viscous,
    "Coulomb": lambda: st.Coulomb(0.3),
    "Family": lambda: st.disk_family("rolling", "viscous"),
    "System": lambda: st.disk_system("viscous"),
    "UPRIGHT": lambda: st.UPRIGHT,
    "Verdict": lambda: st.Verdict.STABLE,
    "Ellipsis": lambda: ...,
    "slice": lambda: slice(3),
    "nested": lambda: {"a": [{"b": (1, [2, {"c": 3}])}] * 50},
}


def _bent(r: random.Random, value: Any) -> tuple[str, Any]:
    """A value made odd in part: an entry, the shape, the sign, the size."""
    if isinstance(value, (list, tuple)) and value:
        kind, i = r.randrange(4), r.randrange(len(value))
        items = list(value)
        if kind == 0:
            del items[i]
        elif kind == 1:
            items.insert(i, items[i])
        else:
            word, items[i] = odd(r)
            return f"entry {i} is {word}", type(value)(items)
        return f"{len(items)} entries", type(value)(items)
    if isinstance(value, dict):
        items = dict(value)
        word, other = odd(r)
        key = r.choice([*items, "nothing", 3])
        items[key] = other
        return f"entry {key!r} is {word}", items
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        factor = r.choice([-1, 0, 1e-3, 1e3, 1e-9, 1e9, 1e100, 1e-100, 1e200])
        if isinstance(value, int) and abs(value) > 10**300:  # no double is that large
            return "minus one", value - 1
        return f"times {factor:g}", value * factor
    if isinstance(value, str) and value:
        return "half a word", value[: len(value) // 2]
    if isinstance(value, np.ndarray):
        return "one axis more", value[..., None]
    return odd(r)


def odd(r: random.Random, value: Any = None) -> tuple[str, Any]:
    """A word for an odd value, and the value; now and then the given one bent."""
    if value is not None and r.random() < 0.35:
        return _bent(r, value)
    word = r.choice(list(VALUES))
    return word, VALUES[word]()
