"""Kinds of quantities with their units, and a quantity as a record, for any body."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from enum import Enum
from typing import Any, Self

from .errors import ParameterError, listed, shown


class Kind(Enum):
    """SI unit of a kind; its unit where m, R and g are 1, in words; and the size of that 1."""

    si: str
    words: str
    size: Callable[[Units], Any]

    NUMBER = "1", "", lambda _units: 1.0
    ANGLE = "rad", "", lambda _units: 1.0
    ANGULAR_VELOCITY = "rad/s", "√(g/R)", lambda units: units.rate
    GROWTH_RATE = "1/s", "√(g/R)", lambda units: units.rate
    VELOCITY = "m/s", "√(gR)", lambda units: units.speed
    ACCELERATION = "m/s2", "g", lambda units: units.gravity
    LENGTH = "m", "R", lambda units: units.length
    TIME = "s", "√(R/g)", lambda units: units.time
    MASS = "kg", "m", lambda units: units.mass
    FORCE = "N", "m g", lambda units: units.force
    ENERGY = "J", "m g R", lambda units: units.energy
    POWER = "W", "m g √(gR)", lambda units: units.force * units.speed
    INVERSE_VELOCITY = "s/m", "1/√(gR)", lambda units: 1 / units.speed
    INVERSE_SQUARE_VELOCITY = (
        "s2/m2",
        "1/(gR)",
        lambda units: 1 / (units.gravity * units.length),
    )
    DRAG = "kg/s", "m √(g/R)", lambda units: units.mass * units.rate

    def __new__(cls, si: str, words: str, size: Callable[[Units], Any]) -> Self:
        """A kind, whose value is its SI unit: so it has a pickle."""
        kind = object.__new__(cls)
        kind._value_ = kind.si = si
        kind.words = words  # none where the number is the same in both systems
        kind.size = size
        return kind

    def unit(self, *, dimensionless: bool) -> str:
        """The unit in a file, where a number without dimension has the unit 1."""
        return "1" if dimensionless and self.words else self.si

    def label(self, *, dimensionless: bool) -> str:
        """The unit for a reader."""
        return self.words if dimensionless and self.words else self.si

    def attributes(self, *, dimensionless: bool) -> dict[str, str]:
        """`units` of a labelled array, and `unit_in_words` where these are 1 by choice of units."""
        if dimensionless and self.words:
            return {"units": "1", "unit_in_words": self.words}
        return {"units": self.si}

    @property
    def suffix(self) -> str:
        """The SI unit after a number in a sentence; nothing for a number without a unit."""
        return "" if self is Kind.NUMBER else f" {readable(self.si)}"


class DefaultScale(float):
    """The 1 of a mass, length or gravity that the caller left out.

    It stays with a body through copies with other numbers, so that these are checked as well.
    """

    __slots__ = ()


ONE = DefaultScale(1.0)
"""Default of a mass, a length and gravity."""


def refuse_partial_units(owner: str, scales: Mapping[str, Any]) -> None:
    """Refuse a body of which some of mass, length and gravity are given, but not all.

    Parameters
    ----------
    owner
        Name of the body.
    scales
        The three numbers by name.

    Examples
    --------
    >>> refuse_partial_units("the disk", {"mass": ONE, "radius": ONE, "gravity": ONE})
    >>> refuse_partial_units("the disk", {"mass": 0.1, "radius": 0.2, "gravity": ONE})
    Traceback (most recent call last):
        ...
    stability.base.errors.ParameterError: the disk has mass and no gravity; give mass, radius and \
gravity in SI units, or none of them.
    """
    missing = [n for n, value in scales.items() if isinstance(value, DefaultScale)]
    if 0 < len(missing) < len(scales):
        present = next(n for n in scales if n not in missing)
        raise ParameterError(
            f"{owner} has {present} and no {missing[0]}; give {listed([*scales])} in SI units, or "
            "none of them."
        )


@dataclass(frozen=True, eq=False)
class Units:
    """The units of a body, over any number type; of a system with units of its own all are 1."""

    mass: Any = 1.0
    """Mass m [kg]."""
    length: Any = 1.0
    """Length R [m]."""
    gravity: Any = 1.0
    """Gravity g [m/s²]."""
    root: Callable[[Any], Any] = math.sqrt
    """Square root of that number type; called only for the units that are asked for."""

    @property
    def time(self) -> Any:
        """Unit of time √(R/g) [s]."""
        return self.root(self.length / self.gravity)

    @property
    def rate(self) -> Any:
        """Unit of angular velocity and growth rate √(g/R) [1/s]."""
        return self.root(self.gravity / self.length)

    @property
    def speed(self) -> Any:
        """Unit of speed √(gR) [m/s]."""
        return self.root(self.gravity * self.length)

    @property
    def force(self) -> Any:
        """Unit of force m g [N]."""
        return self.mass * self.gravity

    @property
    def energy(self) -> Any:
        """Unit of energy m g R [J]."""
        return self.mass * self.gravity * self.length

    def size(self, kind: Kind) -> Any:
        """What a dimensionless 1 of a kind is in these units.

        Parameters
        ----------
        kind
            Any kind.

        Raises
        ------
        ParameterError
            If it is no kind: no number is taken for one without a unit by mistake.

        Examples
        --------
        >>> Units(mass=2.0, length=0.1, gravity=10.0).size(Kind.VELOCITY)
        1.0
        """
        if not isinstance(kind, Kind):
            raise ParameterError(
                f"the kind of a quantity is {shown(kind)}, of which no size in the units of a body "
                f"is known; give one of {', '.join(k.name for k in Kind)}."
            )
        return kind.size(self)


@dataclass(frozen=True)
class Quantity:
    """One quantity: its name in code and files, its symbol, its name in words, its kind."""

    name: str
    """Name in code, files and options."""
    symbol: str
    """Symbol in plain text; empty for a quantity without one."""
    long_name: str
    """Name in words."""
    kind: Kind
    """Kind, which fixes the units."""
    latex: str = ""
    """Symbol in LaTeX without dollars, where the plain symbol differs."""
    formula: str = ""
    """Of a coefficient of a contact law, the law: mu alone is taken for that of dry friction."""

    @property
    def typeset(self) -> str:
        """The symbol as a figure shows it."""
        return f"${self.latex or self.symbol}$" if self.symbol else ""

    def value(self, number: float, *, dimensionless: bool) -> str:
        """A number with symbol and unit, and that of a contact law with it, as plain text.

        Examples
        --------
        >>> Quantity("mass", "m", "mass", Kind.MASS).value(0.5, dimensionless=False)
        'm = 0.5 kg'
        """
        unit = self.kind.label(dimensionless=dimensionless).replace("2", "²")
        ending = (
            "" if unit in ("", "1") else unit.removeprefix("1") if unit[:2] == "1/" else f" {unit}"
        )
        law = f" ({self.formula})" if self.formula else ""
        return f"{self.symbol or self.name} = {number:.6g}{ending}{law}"

    def attributes(self, *, dimensionless: bool) -> dict[str, str]:
        """Long name and units of a labelled array."""
        return {"long_name": self.long_name, **self.kind.attributes(dimensionless=dimensionless)}


_TIMES = {
    **{w: w for w in ("s", "ms", "us", "µs", "μs", "ns", "ps", "fs", "min", "h")},
    **dict.fromkeys(("d", "day", "days"), "day"),
    **dict.fromkeys(("a", "yr", "year", "years"), "year"),
}
_WITH_SECONDS = re.compile(r"[kMGmuµμ]?(N|J|W|Pa|V)")


def time_unit(units: Mapping[str, str]) -> str:
    """The unit of time of a system, from the units of its quantities.

    Parameters
    ----------
    units
        Unit by name, as a user gave them; one called `time` is taken as it is.

    Returns
    -------
    str
        The one unit of time that occurs; 1 where none occurs, or several.

    Examples
    --------
    >>> time_unit({"v": "m/s", "length": "mm"}), time_unit({"k": "N/m"}), time_unit({"a": "1/day"})
    ('s', 's', 'day')
    >>> time_unit({"length": "m"}), time_unit({"v": "m/s", "rate": "1/h"})
    ('1', '1')
    """
    if units.get("time"):
        return str(units["time"])
    times = set()
    for unit in units.values():
        for word in re.findall(r"[^\W\d_]+", str(unit)):
            if word in _TIMES:
                times.add(_TIMES[word])
            elif _WITH_SECONDS.fullmatch(word):
                times.add("s")
    return times.pop() if len(times) == 1 else "1"


def without_dimension(quantities: Mapping[str, Quantity], units: Mapping[str, str]) -> bool:
    """Whether the numbers of a system have no unit, by choice of the units of its quantities.

    Parameters
    ----------
    quantities
        Quantities by name; none of a user's system.
    units
        Unit by name.
    """
    return any(q.kind.words and units.get(n) == "1" for n, q in quantities.items())


def rate_unit(units: Mapping[str, str], quantities: Mapping[str, Quantity] | None = None) -> str:
    """The unit of eigenvalues of a system, from the units of its quantities.

    Parameters
    ----------
    units
        As for `time_unit`.
    quantities
        Quantities of a body by name; none of a user's system.

    Returns
    -------
    str
        One over the unit of time; 1 where that is not known.

    Examples
    --------
    >>> rate_unit({"v": "m/s"}), rate_unit({"time": "beat"}), rate_unit({})
    ('1/s', '1/beat', '1')
    """
    if quantities:
        return Kind.GROWTH_RATE.label(dimensionless=without_dimension(quantities, units))
    time = time_unit(units)
    return "1" if time == "1" else f"1/{time}" if time.isalnum() else f"1/({time})"


def written(quantities: Mapping[str, Quantity]) -> str:
    """Quantities as a text for a file.

    Examples
    --------
    >>> mass = Quantity("mass", "m", "mass", Kind.MASS)
    >>> read(written({"mass": mass})) == {"mass": mass}
    True
    """
    return json.dumps([asdict(q) | {"kind": q.kind.name} for q in quantities.values()])


def read(text: str) -> dict[str, Quantity]:
    """Quantities by name from the text of `written`."""
    rows = [dict(row) for row in json.loads(text)]
    return {q["name"]: Quantity(**q | {"kind": Kind[q["kind"]]}) for q in rows}


def plain_text(name: str) -> str:
    r"""A name as a figure shows it: a dollar sign begins no mathematics.

    Examples
    --------
    >>> print(plain_text("x_1"), plain_text("$a$"))
    x_1 \$a\$
    """
    return name.replace("$", r"\$")


def unit_of(attributes: Mapping[str, Any]) -> str:
    """The unit of a labelled array, in words where its numbers are dimensionless."""
    return str(attributes.get("unit_in_words", attributes.get("units", "1")))


RAISED = dict(zip("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻", strict=True))
"""Digits of an exponent in plain text."""
KNOWN_UNIT = re.compile(
    "(da|[yzafpnuµμmcdhkMGTPEZY])?(m|s|g|N|J|W|Pa|rad|sr|A|V|K|mol|cd|Hz|C|F|Ω|H|T|Wb|S|l|L|eV|bar)"
    "|min|h|d|days?|a|yr|years?|deg|ft|in|lb|mi|yd"
)
"""Words after which a digit is an exponent, also without a sign for it."""
_POWER = re.compile(r"(?<!\w)([^\W\d_]+)(\*\*|\^)?(\(-?\d+\)|-?\d+)(?![\w.])")


def readable(unit: str) -> str:
    """A unit as a reader expects it: exponents are raised, a dot is for a product.

    Parameters
    ----------
    unit
        As it was typed.

    Returns
    -------
    str
        The same where nothing is recognised.

    Examples
    --------
    >>> [readable(u) for u in ("kg m2", "m/s^2", "kg*m**2", "s-1", "beat2", "√(g/R)")]
    ['kg m²', 'm/s²', 'kg·m²', 's⁻¹', 'beat2', '√(g/R)']
    """

    def raised(match: re.Match[str]) -> str:
        word, sign, digits = match.groups()
        if not sign and not (KNOWN_UNIT.fullmatch(word) and digits[0] != "("):
            return match[0]
        return word + "".join(RAISED[c] for c in digits.strip("()"))

    return re.sub(r" ?(?<!\*)\*(?!\*) ?", "·", _POWER.sub(raised, unit))


def behind(unit: str) -> str:
    """A unit as it stands behind a number."""
    return "" if unit in ("", "1") else f" {readable(unit)}"


def axis_label(quantity: Quantity | None, name: str, unit: str) -> str:
    """Name in words, symbol and unit of an axis; the bare name where its quantity is not known."""
    words = f"{quantity.long_name} {quantity.typeset}".strip() if quantity else plain_text(name)
    if quantity and quantity.formula:
        words += f" of {formula_in_latex(quantity.formula)}"
    return words + ("" if unit == "1" else f"  [{in_latex(unit)}]")


def formula_in_latex(formula: str) -> str:
    r"""A law as a figure shows it.

    Examples
    --------
    >>> print(formula_in_latex("F = -μ N v"))
    $F = -\mu\,N\,v$
    """
    left, equals, right = formula.replace(*_ROOT).partition(" = ")
    typeset = left + equals + right.replace(" ", r"\,")
    return f"${typeset.replace('μ', _MU)}$"


_MU = r"\mu"
_ROOT = "√(v² + ε²)", r"\sqrt{v^2+\varepsilon^2}"


def in_latex(unit: str) -> str:
    """The unit of a kind as a figure shows it; any other unit as a reader expects it.

    Examples
    --------
    >>> in_latex("m g"), in_latex("m/s2"), in_latex("kg m2")
    ('$mg$', 'm/s$^2$', 'kg m²')
    """
    return _IN_LATEX.get(unit) or plain_text(readable(unit))


def _in_latex(words: str) -> str:
    root = re.sub(r"√\((.*?)\)", r"\\sqrt{\1}", words)
    return f"${root.replace(' ', '')}$"


# metres come last and win: in words m is a mass, which no figure shows
_IN_LATEX = {k.words: _in_latex(k.words) for k in Kind if k.words} | {
    k.si: re.sub("(?<=[a-z])2", "$^2$", k.si) for k in Kind
}
