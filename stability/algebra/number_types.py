"""Number types in which a graph is read: NumPy arrays, balls, SymPy, heyoka, CasADi itself."""

from __future__ import annotations

import operator
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache, lru_cache, partial
from importlib import import_module
from importlib.util import find_spec
from math import isfinite, prod
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import Any

import casadi as ca
import numpy as np
from flint import arb, ctx

from .upright import Upright


@dataclass(frozen=True, eq=False)
class Algebra:
    """A number type: its constants, and its functions beyond + - * /; equal to itself alone."""

    name: str
    """Name of the number type."""
    constant: Callable[[float], Any]
    """Function from a double to the same number in this type, exactly."""
    functions: dict[str, Callable[..., Any]]
    """sin, cos, tan, sqrt, exp, log, … by name."""
    lasting: bool = True
    """Whether a program may keep its constants in this type for its next run."""


TESTED = ("7.13.2",)
"""Versions of heyoka whose import needs SymPy for `to_sympy` and `from_sympy` alone."""
KEPT = 2**26
"""Bytes of machine code that heyoka keeps on disk for this package.  At its first use in a process
it reads the whole file, which by default grows to 20 GiB: each takes a third of a second."""
MOST_FACTORS = 64
"""Largest whole exponent for which a power is a product."""

UNARY = ("sin", "cos", "tan", "sqrt", "exp", "log", "asin", "acos", "atan", "sinh", "cosh", "tanh")


MORE = ("expm1", "log1p", "asinh", "acosh", "atanh")
"""Further functions of one number; `BY_OTHERS` where a number type lacks one."""


def _by_root(f: dict[str, Callable[..., Any]], x: Any) -> Any:
    share = x / (f["sqrt"](x * x + 1) + 1)  # tanh(y/2) of the result y, without cancellation
    return f["log"](share + 1) - f["log"](-share + 1)


BY_OTHERS: dict[str, Callable[..., Any]] = {
    "expm1": lambda f, x: f["exp"](x) - 1,
    "log1p": lambda f, x: f["log"](x + 1),
    "asinh": _by_root,
    "acosh": lambda f, x: f["log"](x + f["sqrt"](x * x - 1)),
    "atanh": lambda f, x: (f["log"](x + 1) - f["log"](-x + 1)) / 2,
    "hypot": lambda f, y, x: f["sqrt"](x * x + y * y),
    # 0/0 at y = 0 ≥ x, where the angle jumps
    "atan2": lambda f, y, x: f["atan"](y / (f["sqrt"](x * x + y * y) + x)) * 2,
}
"""Functions by those of `UNARY`, from the table f of a number type."""


def function_of(functions: dict[str, Callable[..., Any]], name: str) -> Callable[..., Any]:
    """A function of a number type, its own or by other functions.

    Examples
    --------
    >>> function_of(sympy_algebra().functions, "log1p")(2)
    log(3)
    """
    return functions.get(name) or partial(BY_OTHERS[name], functions)


def numpy_algebra() -> Algebra:
    """Double-precision arrays, elementwise.

    Examples
    --------
    >>> numpy_algebra().functions["sqrt"](4.0)
    np.float64(2.0)
    """
    other: dict[str, Callable[..., Any]] = {
        "asin": np.arcsin,
        "acos": np.arccos,
        "atan": np.arctan,
        "pow": np.power,
    }
    other |= {"fabs": np.abs, "expm1": np.expm1, "log1p": np.log1p, "asinh": np.arcsinh}
    other |= {"acosh": np.arccosh, "atanh": np.arctanh, "hypot": np.hypot, "atan2": _angle}
    table = {name: getattr(np, name) for name in UNARY if name not in other}
    return Algebra("numpy", float, table | other)


def _angle(y: Any, x: Any) -> Any:
    """The angle of (x, y); nan where the angle jumps by a turn."""
    return np.where(np.equal(y, 0) & np.less_equal(x, 0), np.nan, np.arctan2(y, x))


@lru_cache(maxsize=1)
def balls() -> Algebra:
    """Real balls of python-flint at its context's precision: a result encloses the exact value.

    Examples
    --------
    >>> balls().functions["sqrt"](balls().constant(4.0))
    2.00000000000000
    """
    names = (*UNARY, *MORE)
    table: dict[str, Callable[..., Any]] = {name: operator.methodcaller(name) for name in names}
    table |= {"pow": ball_power, "fabs": abs, "sign": ball_sign, "atan2": ball_angle}
    return Algebra("ball", arb, table)


def ball_sign(x: Any) -> Any:
    """The sign of a ball or an exact number; nan where it is not known.

    Examples
    --------
    >>> from flint import arb
    >>> ball_sign(arb(2, 1)), ball_sign(arb(0, 1))
    (1, nan)
    """
    return 1 if x > 0 else -1 if x < 0 else arb("nan")


def ball_angle(y: Any, x: Any) -> Any:
    """The angle of (x, y) as a ball; nan where the angle may jump by a turn.

    Parameters
    ----------
    y, x
        Balls, or exact numbers.

    Examples
    --------
    >>> from flint import arb
    >>> ball_angle(arb(0, 1), arb(2)).is_finite(), ball_angle(arb(0, 1), arb(-2)).is_finite()
    (True, False)
    """
    x, y = arb(x), arb(y)
    return arb.atan2(y, x) if x > 0 or y > 0 or y < 0 else arb("nan")


def ball_power(x: Any, y: Any) -> Any:
    """A power of balls; python-flint's own is nan for a whole power of a ball around 0.

    Examples
    --------
    >>> from flint import arb
    >>> ball_power(arb(0, 2), arb(3)).is_finite()
    True
    """
    x, y = arb(x), arb(y)
    if not (y.is_integer() and abs(y) <= MOST_FACTORS and x.contains(0)):
        return x**y
    power = prod([x] * abs(int(float(y))), start=x * 0 + 1)
    return power if y >= 0 else 1 / power


def sympy_algebra() -> Algebra:
    """SymPy expressions, with every constant an exact rational, or nan where it is not finite.

    Examples
    --------
    >>> sympy_algebra().constant(0.25)
    1/4
    """
    import sympy

    def constant(value: float) -> Any:  # SymPy's Rational reads an infinity as 0
        return sympy.Rational(value) if isfinite(value) else sympy.nan

    names = (*UNARY, "asinh", "acosh", "atanh", "atan2")
    table = {name: getattr(sympy, name) for name in names}
    return Algebra("sympy", constant, table | {"pow": sympy.Pow, "fabs": sympy.Abs})


def casadi_algebra() -> Algebra:
    """CasADi's own SX, which folds constants, for a graph at the exact right angle.

    Examples
    --------
    >>> casadi_algebra().constant(0.25)
    SX(0.25)
    """

    def exact(name: str) -> Callable[[Any], Any]:
        # only this algebra meets the exact right angle
        return lambda x: getattr(x, name)() if isinstance(x, Upright) else getattr(ca, name)(x)

    table: dict[str, Callable[..., Any]] = {name: exact(name) for name in (*UNARY, *MORE)}
    table |= {"pow": ca.power, "fabs": ca.fabs, "sign": _casadi_sign, "atan2": ca.atan2}
    return Algebra("casadi", ca.SX, table)


def _casadi_sign(x: Any) -> Any:
    """The sign, which has no value at the number 0; CasADi's own is 0 there."""
    return x / ca.fabs(x) if ca.SX(x).is_constant() else ca.sign(x)


class _Later:
    """A function or module of SymPy that is looked up when it is first called."""

    def __init__(self, find: Callable[[], Any]) -> None:
        self.find = find

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        if isinstance(sys.modules.get("sympy"), _SymPyLater):  # heyoka is being imported
            return _Later(lambda: self.find()(*arguments, **named))
        return self.find()(*arguments, **named)

    def __getattr__(self, name: str) -> Any:
        return _Later(lambda: getattr(self.find(), name))


class _SymPyLater(ModuleType):
    """In the place of SymPy during the import of heyoka."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return _Later(lambda: getattr(import_module("sympy"), name))


class _FunctionsLater:
    """heyoka's table of SymPy's functions, made when it is first read."""

    def __init__(self, build: Callable[[], Any]) -> None:
        self.table = cache(build)

    def __contains__(self, key: Any) -> bool:
        return key in self.table()

    def __getitem__(self, key: Any) -> Any:
        return self.table()[key]


def _known() -> bool:
    """Whether this heyoka was tested with the stand-in; another one may use SymPy on import."""
    from importlib.metadata import PackageNotFoundError, version  # slow to import

    try:
        return version("heyoka") in TESTED
    except PackageNotFoundError:
        return False


def heyoka() -> Any:
    """The library heyoka, whose import does not wait for SymPy, nor its first use for a large file.

    heyoka imports the whole of SymPy, for `heyoka.to_sympy` and `heyoka.from_sympy` alone.  A first
    motion would wait for SymPy as long as for everything else.  Here both functions import SymPy
    when they are first called.  Versions that are not in `TESTED` are imported plainly.

    A program that has imported heyoka itself keeps its settings.

    Raises
    ------
    ImportError
        If heyoka is not installed.
    """
    if "heyoka" in sys.modules:
        return import_module("heyoka")
    library = _imported()
    with suppress(AttributeError, RuntimeError):  # an older version; no folder can be written
        state = library.llvm_state
        folder = Path(state.get_diskcache_path())
        if folder.is_absolute():
            state.set_diskcache_path(folder / "stability")
            state.set_diskcache_limit(KEPT)
    return library


def _imported() -> Any:
    """Heyoka, with a stand-in for SymPy where that is safe."""
    if "sympy" in sys.modules:
        return import_module("heyoka")
    others = [t for t in threading.enumerate() if t is not threading.current_thread()]
    # a thread that imports SymPy meanwhile would find the stand-in; that of a progress bar does not
    alone = all(type(t).__module__.startswith(("tqdm", "stability.cli")) for t in others)
    spec = find_spec("sympy") if alone and _known() else None
    if spec is None:
        return import_module("heyoka")
    later = sys.modules["sympy"] = _SymPyLater("sympy")
    later.__spec__ = spec
    try:
        library = import_module("heyoka")
    finally:
        del sys.modules["sympy"]
    back: Any = sys.modules.get("heyoka._sympy_utils")
    if hasattr(back, "_build_fmap"):
        back._fmap = _FunctionsLater(back._build_fmap)
    return library


@lru_cache(maxsize=1)
def heyoka_algebra() -> Algebra:
    """Expressions of heyoka."""
    hy = heyoka()
    hy.set_logger_level_critical()  # it logs to standard output, which is the user's
    names = ("sin", "cos", "tan", "sqrt", "exp", "log", "asin", "acos", "atan", "sinh", "cosh")
    table: dict[str, Callable[..., Any]] = {n: getattr(hy, n) for n in (*names, "tanh")}
    table["pow"] = lambda x, y: x**y
    return Algebra("heyoka", hy.expression, table)


def upper(ball: Any) -> float:
    """A double that is not below any number of a ball; 0 for an exact zero."""
    if ball == 0:
        return 0.0
    return float(np.nextafter(float(ball.abs_upper()), np.inf))


_PRECISION = RLock()


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """A context with balls of the given precision; the former precision returns afterwards.

    Examples
    --------
    >>> from flint import arb
    >>> with precision(200):
    ...     print((arb(1) / 3).rel_accuracy_bits() > 190)
    True
    """
    with _PRECISION:  # one precision for the whole process: threads take turns
        before = ctx.prec
        ctx.prec = bits
        try:
            yield
        finally:
            ctx.prec = before


MIXED = Algebra(
    "rationals and balls",
    arb,
    {name: partial(lambda method, x: getattr(arb(x), method)(), name) for name in (*UNARY, *MORE)}
    | {"pow": ball_power, "fabs": abs, "sign": ball_sign, "atan2": ball_angle},
)
"""Rationals stay rational; a function makes them balls."""
