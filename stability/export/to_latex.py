"""Equations of motion, linearised equations, characteristic polynomial, conditions in LaTeX."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, count
from math import prod
from typing import Any

import casadi as ca
import sympy
from sympy.printing.latex import LatexPrinter

from ..algebra.number_types import Algebra, sympy_algebra
from ..algebra.polynomial import Polynomial
from ..algebra.program import Program
from ..algebra.upright import Upright
from ..base.errors import ParameterError, shown
from ..bodies.contact_laws import Contact
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..bodies.subject import family_by_name
from ..derivation.conditions import Conditions, conditions
from ..derivation.latex import ROOM, dotted, escaped, scientific, symbols, width
from ..systems.equations import Equations
from ..systems.family import Family
from ..systems.graph.family_graph import solved_rates
from ..systems.sources.numeric import NumericSystem

HEAD = r"""\documentclass[twocolumn]{article}
\usepackage{amsmath}
\usepackage[margin=15mm]{geometry}
\allowdisplaybreaks
\begin{document}
"""
"""The document around the formulas: amsmath and geometry, of every LaTeX."""
Expr = Any
"""A SymPy expression; SymPy states no types."""


def latex(
    subject: Equations | Family | Conditions | str,
    *,
    contact: Contact | type[Contact] | str | None = None,
    body: Body | Disk | None = None,
    positive: Sequence[str] = (),
    standalone: bool = True,
    **parameters: Any,
) -> str:
    r"""Equations of motion, linearised equations, characteristic polynomial, conditions in LaTeX.

    Lines fit a column of 85 mm.  Equations with a mass matrix stay M u̇ = f, a row each.  Long
    divisors and roots get names, D_1, R_1, …, with a line each.

    Parameters
    ----------
    subject
        A `System` (its equations of motion, and these linearised about any motion); a `Family` (the
        same about its steady motions, then the characteristic polynomial and the conditions of
        stability, derived exactly), or its name; or `Conditions` that were derived before (these
        alone).
    contact, body
        With a family by its name, as for `stability.conditions`.
    positive
        Positive variables of the conditions, as for `stability.conditions`.
    standalone
        Whether the text is a document of its own; otherwise it is a part for one with amsmath.
    **parameters
        Numbers for parameters, in the conditions of a family.

    Returns
    -------
    str
        A document, or the part within one.  Numbers that are no short fractions have 17 digits.

    Raises
    ------
    ParameterError
        If the subject is something else, or has no graph.

    Source: the graph itself; tests/export/test_latex.py reads the formulas back.

    Examples
    --------
    >>> import casadi as ca, stability as st
    >>> x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    >>> pendulum = st.System("pendulum", x, p, ca.vertcat(x[1], -p * ca.sin(x[0])),
    ...                      states=("theta", "omega"), parameters=("g",))
    >>> print(st.export.latex(pendulum, standalone=False).splitlines()[3])
    &\dot{\omega} = - g \, \sin {\theta}
    """
    subject = family_by_name(subject, body, contact, parameters, "subject")
    if isinstance(subject, Conditions):
        parts = _of_conditions(subject)
    elif isinstance(subject, Family):
        _graph_of(subject.system)
        derived = conditions(subject, positive=positive, **parameters)
        parts = [*_of_family(subject), *_of_conditions(derived)]
    elif isinstance(subject, Equations):
        parts = _of_system(_graph_of(subject))
    else:
        raise ParameterError(
            f"subject is {shown(subject)}; give a System, a Family or its name, or Conditions."
        )
    text = "\n".join(parts) + "\n"
    return f"{HEAD}{text}\\end{{document}}\n" if standalone else text


def _graph_of(system: Equations) -> Equations:
    if isinstance(system, NumericSystem):
        raise ParameterError(
            f"{system.name} is a Python function without formulas; give a System with a graph."
        )
    system.refuse_algebraic("latex")
    return system


# --- equations of motion ---


class Modulus(sympy.Function):  # type: ignore[misc]
    """The absolute value of a real number; its slope is the sign."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """The slope."""
        assert argindex == 1
        return Sign(self.args[0])


class Sign(sympy.Function):  # type: ignore[misc]
    """The sign of a real number; its slope is zero."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """The slope."""
        assert argindex == 1
        return sympy.Integer(0)


_SYMPY = sympy_algebra()
ALGEBRA = Algebra("latex", _SYMPY.constant, _SYMPY.functions | {"fabs": Modulus, "sign": Sign})
"""The number type for `Program.run`."""


@dataclass(frozen=True)
class _Motion:
    """Equations of motion: rates, and residuals M u - f, as expressions in named symbols."""

    system: Equations
    names: Mapping[str, str]
    """LaTeX of states, parameters and more variables by name."""
    rates: Mapping[str, Expr]
    """Rates by state, of those that no residual gives."""
    unknowns: Mapping[Expr, str]
    """LaTeX of the unknowns u: rates of states, and forces."""
    mass: Sequence[Sequence[Expr]] = ()
    forcing: Sequence[Expr] = ()

    @classmethod
    def of(cls, system: Equations, more: Iterable[str] = ()) -> _Motion:
        names = symbols((*system.states, *system.parameters, *more))
        inputs = [[_symbol(n) for n in group] for group in (system.states, system.parameters)]
        solved = solved_rates(system) if system.mass is not None else {}
        free = [i for i in range(len(system.states)) if i not in solved]
        sides = [
            ca.densify(s) for s in (system.rhs[free], system.mass, system.forcing) if s is not None
        ]
        graph = ca.Function("sides", [system.x, system.p], sides)
        rates, *rest = [
            [sympy.sympify(v) for v in side] for side in Program(graph).run(ALGEBRA, inputs)
        ]
        sizes: dict[Expr, int] = {}
        if (signs := sum(_size(e, sizes) for e in chain(rates, *rest))) > LARGEST:
            raise ParameterError(
                f"{system.name} has equations of {signs:.1g} symbols and signs, too many to print; "
                "stability.export.c_code writes them as code."
            )
        if any(e.has(sympy.zoo, sympy.nan) for e in chain(rates, *rest)):
            raise ParameterError(
                f"{system.name} has a number that is not finite, such as 1/0; give finite ones."
            )
        table = {system.states[i]: rate for i, rate in zip(free, rates, strict=True)}
        for state, rate in table.items():  # q_rate, if it is the rate of q, reads as a velocity
            if str(rate) == f"{state}_rate" in system.states:
                names[f"{state}_rate"] = dotted(names[state])
        if not rest:
            return cls(system, names, table, {})
        matrix, forcing = rest
        size = len(system.unknowns)
        unknowns = {}
        for name in system.unknowns:
            state = name.removeprefix("d_")
            observed = symbols([state])[state] if state in system.observables else ""
            rate = name.startswith("d_") and (names.get(state) or observed)
            unknowns[_symbol(name)] = dotted(rate) if rate else symbols([name])[name]
        rows = [matrix[i::size] for i in range(size)]
        return cls(system, names, table, unknowns, rows, forcing)

    @property
    def latex(self) -> dict[Expr, str]:
        """LaTeX by symbol."""
        return {_symbol(n): text for n, text in self.names.items()} | dict(self.unknowns)

    def equations(self, sheet: Sheet) -> list[list[str]]:
        """Each equation as its terms; a rate that is called the rate says nothing."""
        rates = {s: (dotted(self.names[s]), rate) for s, rate in self.rates.items()}
        rows = [
            [left, *sheet.equal(rate)]
            for left, rate in rates.values()
            if bare(sheet.text(rate)) != bare(left)
        ]
        for row, forcing in zip(self.mass, self.forcing, strict=True):
            left = [(c, text) for c, text in zip(row, self.unknowns.values(), strict=True)]
            rows.append([*sheet.linear(left), *sheet.equal(forcing)])
        return rows

    def linearised(self, sheet: Sheet, values: Mapping[Expr, Expr]) -> list[list[str]]:
        """The equations in deviations, each as its terms, about a motion with some values."""
        deviations = [(_symbol(s), rf"\delta {self.names[s]}") for s in self.system.states]

        def slopes(side: Expr) -> list[str]:
            right = [(sympy.diff(side, x).subs(values), d) for x, d in deviations]
            return _related(sheet.linear(right))

        rows = [
            [rf"\delta {dotted(self.names[s])}", *slopes(rate)]
            for s, rate in self.rates.items()
            if bare(written(rate, self.latex)) != bare(dotted(self.names[s]))
        ]
        for row, forcing in zip(self.mass, self.forcing, strict=True):
            pairs = list(zip(row, self.unknowns.items(), strict=True))
            left = [(c.subs(values), rf"\delta {text}") for c, (_, text) in pairs]
            rows.append([*sheet.linear(left), *slopes(forcing - sum(c * u for c, (u, _) in pairs))])
        return rows

    def steady(self, family: Family) -> tuple[dict[Expr, Expr], list[Expr]]:
        """Values of states and unknowns in a steady motion, and which unknowns are forces."""
        values: dict[Expr, Expr] = {
            _symbol(n): sympy.pi / 2 if isinstance(v, Upright) else sympy.Rational(float(v))
            for n, v in family.held.items()
        }
        still = [_symbol(f"d_{s}") for s in self.system.states if s not in family.left_out]
        values |= {u: sympy.Integer(0) for u in still if u in self.unknowns}
        residuals = [
            (sum(c * u for c, u in zip(row, self.unknowns, strict=True)) - f).subs(values)
            for row, f in zip(self.mass, self.forcing, strict=True)
        ]
        forces: list[Expr] = []
        for _ in residuals:  # a row with one force gives it
            for residual in residuals:
                left = [u for u in self.unknowns if residual.subs(values).has(u)]
                if len(left) == 1:
                    [force] = left
                    slope = sympy.diff(residual, force)
                    rest = residual.subs(force, 0)
                    values[force] = shortest(-(rest / slope).subs(values), self.latex)
                    forces.append(force)
        return values, forces


def _symbol(name: str) -> Expr:
    return sympy.Symbol(name)


def _size(expression: Expr, sizes: dict[Expr, int]) -> int:
    """How many symbols and signs it takes to write an expression."""
    if expression not in sizes:
        sizes[expression] = 1 + sum(_size(part, sizes) for part in expression.args)
    return sizes[expression]


def bare(latex: str) -> str:
    r"""LaTeX without braces and spaces: \dot\theta is \dot{\theta}."""
    return re.sub(r"[{} ]", "", latex)


def _of_system(system: Equations) -> list[str]:
    """Equations of motion, and these linearised about any motion."""
    motion = _Motion.of(system)
    sheet = Sheet(motion.latex)
    return [
        rf"\section*{{Equations of motion: {escaped(system.name)}}}",
        *sheet.display(motion.equations(sheet)),
        r"\section*{Linearised equations}",
        *sheet.display(motion.linearised(sheet, {})),
    ]


def _of_family(family: Family) -> list[str]:
    """Equations of motion, the steady motions, and the equations linearised about them."""
    motion = _Motion.of(family.system, (*family.at, *family.parameters))
    names, sheet = motion.names, Sheet(motion.latex)
    values, forces = motion.steady(family)
    said = [rf"{names[n]} = {sheet.text(values[_symbol(n)])}" for n in family.held]
    said += [rf"{names[n]}\text{{ solved for}}" for n in family.unknown]
    said += [rf"{names[n]}\text{{ of any value}}" for n in family.left_out]
    said = [
        *(rf"{formula},\;" for formula in said),
        rf"\text{{named by }}{', '.join(names[n] for n in family.at)}",
    ]
    return [
        rf"\section*{{Equations of motion: {escaped(family.system.name)}}}",
        *sheet.display(motion.equations(sheet)),
        rf"\section*{{Steady motions: {escaped(family.name)}}}",
        *sheet.display([said]),
        *sheet.display([[sheet.text(n), *sheet.equal(values[n])] for n in forces]),
        r"\section*{Linearised equations}",
        *sheet.display(motion.linearised(sheet, values)),
    ]


# --- polynomials and conditions ---


def _of_conditions(derived: Conditions) -> list[str]:
    """The characteristic polynomial by its factors, and the sign conditions."""
    every = [v.name for v in derived.variables]
    every += [v for c in derived.conditions for v in c.polynomial.variables]
    names = symbols((*every, "lambda"))
    sheet = Sheet({_symbol(n): text for n, text in names.items()})
    lam = names["lambda"]

    def power(n: int) -> str:
        return "" if n == 0 else lam if n == 1 else f"{lam}^{{{n}}}"

    factors, rows = [power(derived.zeros)] * (derived.zeros > 0), []
    for i, factor in enumerate(derived.factors, start=1):
        many = f"^{{{factor.multiplicity}}}" if factor.multiplicity > 1 else ""
        factors.append(rf"p_{{{i}}}({lam}){many}")
        whole, named = [], []
        scale = _scale(factor.coefficients)
        for n in reversed(range(len(factor.coefficients))):
            value = shortest(_expression(factor.coefficients[n], scale), sheet.names)
            if value.is_Add and width(sheet.text(value)) > ROOM - 4:
                name = rf"p_{{{i},{n}}}"
                named.append([name, *sheet.equal(value)])
                whole.append(f"+ {name} {power(n)}")
            else:
                whole += sheet.terms(value, power(n))
        rows += [[rf"p_{{{i}}}({lam})", *_related(whole)], *named]
    out = [r"\section*{Characteristic polynomial}", rf"\[ {' '.join(factors)} = 0 \]"]
    out += sheet.display(rows)
    zeros = [sheet.sum(_expression(p)) for _, p in derived.relations]
    if zeros := [zero for zero in zeros if zero != ["0"]]:  # sin² + cos² = 1 goes without saying
        out += ["with", *sheet.display([*zero, f"{last} = 0"] for *zero, last in zeros)]
    out.append(r"\section*{Conditions of stability}")
    asked = [c for c in derived.conditions if any(any(e) for _, e in c.polynomial.terms)]
    if derived.branch and asked:
        out.append(rf"\noindent On {escaped(derived.branch)}:")
    for condition in asked:
        status = condition.status + " sign" * (condition.status == "changes")
        out.append(
            rf"\noindent {escaped(condition.name)} of $p_{{{condition.factor + 1}}}$: {status}"
        )
        sign = {"negative": "<", "zero": "="}.get(condition.status, ">")
        side = shortest(
            _expression(condition.polynomial, _scale([condition.polynomial])), sheet.names
        )
        *terms, last = sheet.sum(side)
        out += sheet.display([[*terms, f"{last} {sign} 0"]])
    return out if asked else [*out, rf"\noindent {escaped(derived.rule)}"]


def _scale(polynomials: Sequence[Polynomial]) -> int:
    """A power of ten that makes long coefficients short; 1 where they are."""
    sizes = [abs(c) for p in polynomials for c, _ in p.terms]
    return 10 ** (len(str(min(sizes))) - 1) if max(sizes) > LONGEST else 1


def _expression(p: Polynomial, scale: int = 1) -> Expr:
    """A polynomial in the symbols of its variables; sin(theta) is a sine."""
    values = []
    for name in p.variables:
        match = re.fullmatch(r"(sin|cos|sqrt)\((\w+)\)", name)
        values.append(getattr(sympy, match[1])(_symbol(match[2])) if match else _symbol(name))
    return sympy.Add(
        *(
            sympy.Rational(int(c), scale)
            * sympy.prod(v**e for v, e in zip(values, exponents, strict=True))
            for c, exponents in p.terms
        )
    )


# --- expressions in lines of a column ---


MOST = 400
"""Terms above which a sum of products is not multiplied out."""
LONG = 4.0
"""Width of a divisor or root that gets a name [em]."""
LARGEST = 20_000
"""Symbols and signs above which equations are not printed."""
LONGEST = 10**12
"""Largest whole number that is written with all digits."""


class _Printer(LatexPrinter):  # type: ignore[misc]
    """SymPy's printer, with numbers as Python writes them."""

    def _print_Float(self, value: Expr) -> str:
        return scientific(repr(float(value)).removesuffix(".0"))

    def _print_Sign(self, value: Expr) -> str:
        arguments = ", ".join(map(self._print, value.args))
        return rf"\operatorname{{{type(value).__name__.lower()}}}\left({arguments}\right)"

    _print_atan2 = _print_Sign

    def _print_Modulus(self, value: Expr, exp: str = "") -> str:
        power = f"^{{{exp}}}" if exp else ""
        return rf"\left|{{{self._print(value.args[0])}}}\right|{power}"


def _decimal(value: Expr) -> Expr:
    """A number that is no short fraction as the nearest double."""
    return sympy.Float(float(value), 17) if value.q > 1000 or abs(value.p) > LONGEST else value


def written(expression: Expr, names: Mapping[Expr, str]) -> str:
    r"""An expression in LaTeX.

    Examples
    --------
    >>> x = sympy.Symbol("x")
    >>> print(written(sympy.sin(x) ** 2 / 3 + 1.3 * x, {x: r"\xi"}))
    1.3 \, \xi + \frac{\sin^{2} {\xi}}{3}
    """
    expression = expression.replace(lambda e: e.is_Rational, _decimal)
    settings = {
        "symbol_names": dict(names),
        "fold_func_brackets": True,
        "mul_symbol": r" \, ",
        "inv_trig_style": "full",
    }
    return str(_Printer(settings).doprint(expression))


def terms_of(expression: Expr, sizes: dict[Expr, int] | None = None) -> int:
    """The number of terms after multiplying out, or more.

    Examples
    --------
    >>> x, y = sympy.symbols("x y")
    >>> terms_of((x + y) ** 3 * (1 + x))
    16
    """
    sizes = {} if sizes is None else sizes
    if expression not in sizes:
        counts = [terms_of(part, sizes) for part in expression.args]
        if expression.is_Add:
            sizes[expression] = sum(counts)
        elif expression.is_Mul:
            sizes[expression] = min(prod(counts), 10**9)
        elif expression.is_Pow and expression.exp.is_Integer and expression.exp > 0:
            sizes[expression] = min(counts[0] ** min(int(expression.exp), 30), 10**9)
        else:
            sizes[expression] = 1
    return sizes[expression]


def multiplied_out(expression: Expr) -> Expr:
    """A sum of products, where these are not too many."""
    if terms_of(expression) > MOST:
        return expression
    return sympy.expand(expression, power_exp=False, power_base=False, log=False)


def shortest(expression: Expr, names: Mapping[Expr, str]) -> Expr:
    """The shortest of a few forms of an expression: as it is, multiplied out, sin² for cos²."""
    if terms_of(expression) > MOST:
        return expression
    forms = [expression, sums := multiplied_out(expression)]
    for kind, other in ((sympy.sin, sympy.cos), (sympy.cos, sympy.sin)):

        def by_other(power: Expr, other: Callable[..., Expr] = other) -> Expr:
            whole, odd = divmod(int(power.exp), 2)
            return (1 - other(*power.base.args) ** 2) ** whole * power.base**odd

        forms.append(
            multiplied_out(
                sums.replace(
                    lambda e, kind=kind: (
                        e.is_Pow and e.base.func is kind and e.exp.is_Integer and e.exp > 1
                    ),
                    by_other,
                )
            )
        )
    forms += [sympy.factor_terms(form) for form in forms]
    return min(dict.fromkeys(forms), key=lambda form: width(written(form, names)))


def _related(terms: Sequence[str]) -> list[str]:
    """Terms on the right of a sign of equality; none are zero."""
    first, *rest = terms or ["+ 0"]
    return [f"= {first.removeprefix('+ ')}", *rest]


@dataclass
class Sheet:
    r"""Equations in lines of a column, with names for long divisors and roots.

    Examples
    --------
    >>> x, y = sympy.symbols("x y")
    >>> sheet = Sheet({})
    >>> sheet.equal(x / (1 + x + x * y + y) ** 2)
    ['= \\frac{x}{D_{1}^{2}}']
    >>> print(*sheet.display([["y", "= 2"]]), sep="\n")
    \begin{align*}
    &D_{1} = x \, y + x + y + 1 \\
    &y = 2
    \end{align*}
    """

    names: dict[Expr, str]
    """LaTeX by symbol."""
    _named: dict[tuple[str, Expr], Expr] = field(default_factory=dict)
    _lines: list[list[str]] = field(default_factory=list)

    def text(self, expression: Expr) -> str:
        """An expression in LaTeX."""
        return written(expression, self.names)

    def _short(self, expression: Expr) -> Expr:
        """The shortest form, with names for long divisors and roots."""

        def divides(e: Expr) -> bool:
            named = e.is_Pow and e.base.is_Add and e.exp.is_Rational
            return bool(named and (e.exp < 0 or e.exp.q == 2))

        return shortest(expression.replace(divides, self._name), self.names)

    def _name(self, power: Expr) -> Expr:
        """A divisor or root by its name, if it is long."""
        base, exponent = power.args
        root = exponent.q == 2
        whole = shortest(base, self.names)
        value = sympy.sqrt(whole) if root else whole
        if width(self.text(value)) < LONG and exponent > -2:
            return whole**exponent
        key = ("R" if root else "D", value)
        if key not in self._named:
            free = (f"{key[0]}_{{{n}}}" for n in count(1))
            name = next(n for n in free if n not in self.names.values())
            symbol = sympy.Symbol(name, positive=root or None)
            self.names[symbol] = name
            self._named[key] = symbol
            self._lines.append([name, *_related(self._split(value))])
        return self._named[key] ** (2 * exponent if root else exponent)

    def _split(self, value: Expr, factor: str = "") -> list[str]:
        """Terms with their signs, each times a factor."""
        terms = []
        for term in value.as_ordered_terms():
            text = self.text(term)
            sign, size = ("-", text[1:].lstrip()) if text[0] == "-" else ("+", text)
            if factor:
                size = factor if size == "1" else rf"{size} \, {factor}"
            terms.append(f"{sign} {size}")
        return terms

    def terms(self, expression: Expr, factor: str = "") -> list[str]:
        """Terms of an expression times a factor, in short; none of zero."""
        value = self._short(expression)
        if value == 0:
            return []
        if not (factor and value.is_Add):
            terms = self._split(value, factor)
            if max(map(width, terms)) < ROOM:
                return terms
            value = multiplied_out(value)
            if not (factor and value.is_Add):
                return self._split(value, factor)
        whole = rf"\left({self.text(value)}\right) \, {factor}"
        if width(whole) < ROOM:
            return [f"+ {whole}"]
        first, *rest = self.sum(value)
        *terms, last = [rf"+ \bigl({first}", *rest]
        return [*terms, rf"{last}\bigr) \, {factor}"]

    def sum(self, expression: Expr) -> list[str]:
        """Terms of an expression at the start of a line."""
        first, *rest = self.terms(expression) or ["+ 0"]
        return [first.removeprefix("+ "), *rest]

    def equal(self, expression: Expr) -> list[str]:
        """Terms of an expression on the right of an equation."""
        return _related(self.terms(expression))

    def linear(self, pairs: Iterable[tuple[Expr, str]]) -> list[str]:
        """Terms of a sum of coefficients times symbols."""
        return [term for value, symbol in pairs for term in self.terms(value, symbol)]

    def display(self, equations: Iterable[Sequence[str]]) -> list[str]:
        """Equations by their terms, in lines of an aligned display, after new names."""
        lines = []
        for first, *rest in [*self._lines, *equations]:
            line = "&" + first.removeprefix("+ ")
            for term in rest:
                if width(line) + width(term) > ROOM:
                    lines.append(line)
                    line = rf"&\quad{{}}{term}"
                else:
                    line += f" {term}"
            lines.append(line)
        self._lines.clear()
        return [r"\begin{align*}", " \\\\\n".join(lines), r"\end{align*}"] if lines else []
