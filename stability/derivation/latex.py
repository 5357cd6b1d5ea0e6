r"""Names, numbers and words in LaTeX, for formulas and tables alike."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from ..bodies.quantities import QUANTITIES

GREEK = frozenset(
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau phi "
    "chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi Omega".split()
)
GREEK_LETTERS = {
    letter: word
    for word in GREEK
    for letter in [
        unicodedata.lookup(
            f"GREEK {'CAPITAL' if word[0].isupper() else 'SMALL'} LETTER "
            f"{word.upper().replace('LAMBDA', 'LAMDA')}"
        )
    ]
} | {"µ": "mu", "ϕ": "phi", "ϑ": "theta", "ϵ": "epsilon"}
"""Names that LaTeX writes as Greek letters."""
FUNCTIONS = ("sin", "cos", "tan", "exp", "log", "ln", "sinh", "cosh", "tanh")
"""Functions with a name of their own in LaTeX."""
SIGNS = {
    "*": r"\,",
    "≤": r"\le ",
    "≥": r"\ge ",
    "≠": r"\ne ",
    "→": r"\to ",
    "∞": r"\infty ",
    "±": r"\pm ",
    "·": r"\cdot ",
    "×": r"\times ",
    "…": r"\ldots ",
    "{": r"\{",
    "}": r"\}",
    "∂": r"\partial ",
    "′": "'",
    "%": r"\%",
    "&": r"\&",
    "#": r"\#",
    "$": r"\$",
    "~": r"\sim ",
    "≈": r"\approx ",
    "∈": r"\in ",
    "−": "-",
    "–": "-",
    "_": r"\_",
    "\\": r"\backslash ",
    "\u2060": "",
}
"""Signs in formulas."""
ROOM = 21.0
"""Width of a line [em]: of a column of 85 mm in 10 pt, less the rounding of `width`."""
OF_DISK = {
    name: re.sub(r"_(\w)$", r"_{\1}", QUANTITIES[name].latex)
    for name in ("mu", "phi_dot", "theta_dot", "omega3", "theta", "slip_x", "slip_y")
}
"""Symbols of the disk."""


def symbols(names: Iterable[str]) -> dict[str, str]:
    r"""A symbol for each name; two names never share one.

    Examples
    --------
    >>> symbols(["theta", "x_1", "speed", "sin(theta)"])["sin(theta)"]
    '\\sin\\left(\\theta\\right)'
    >>> list(symbols(["q1", "q_1"]).values())
    ['q_{1}', '\\mathit{q\\_1}']
    """
    table: dict[str, str] = {}
    for name in dict.fromkeys(names):
        made = symbol(name)
        if made in table.values():
            made = rf"\mathit{{{escaped(name)}}}"
        table[name] = made
    return table


def symbol(name: str) -> str:
    r"""The name of a variable in mathematics of LaTeX.

    Parameters
    ----------
    name
        Name of a variable, such as `phi_dot` or `sin(theta)`.

    Examples
    --------
    >>> print(symbol("omega_0"), symbol("sin(theta)"), symbol("sqrt(b)"), symbol("de"))
    \omega_{0} \sin\left(\theta\right) \sqrt{b} \mathit{de}
    """
    if name in OF_DISK:
        return OF_DISK[name]
    match = re.fullmatch(r"([^\W\d_]\w*)\((.*)\)", name)
    if match:
        inner = converted(match[2])
        if match[1] == "sqrt":
            return rf"\sqrt{{{inner}}}"
        head = f"\\{match[1]}" if match[1] in FUNCTIONS else rf"\mathrm{{{match[1]}}}"
        return rf"{head}\left({inner}\right)"
    if rate := re.fullmatch(r"(\w+)_dot", name):
        return dotted(symbol(rate[1]))
    first, *rest = [p for p in name.split("_") if p] or ["x"]
    digits = re.fullmatch(r"([A-Za-z]+)(\d+)", first)
    if digits:
        first, rest = digits[1], [digits[2], *rest]
    head = _letter(first)
    return head + (f"_{{{','.join(_letter(r) for r in rest)}}}" if rest else "")


def dotted(latex: str) -> str:
    r"""The rate of a symbol.

    Examples
    --------
    >>> print(dotted("v_{x}"), dotted(r"\dot{\psi}"))
    \dot{v}_{x} \ddot{\psi}
    """
    if latex.startswith(r"\dot"):
        return latex.replace(r"\dot", r"\ddot", 1)
    head, mark, index = latex.partition("_{")
    return rf"\dot{{{head}}}{mark}{index}" if "{" not in head else rf"\dot{{{latex}}}"


def _letter(word: str) -> str:
    if word in GREEK:
        return f"\\{word}"
    if word.isascii() and (len(word) == 1 or word.isdigit()):
        return word
    if word in GREEK_LETTERS:
        return f"\\{GREEK_LETTERS[word]}"
    if not word.isascii() or " " in word:
        return rf"\text{{{escaped(word)}}}"
    safe = "".join(c for c in word if c.isalnum())
    return rf"\mathit{{{safe or 'x'}}}"


def converted(text: str, names: Collection[str] = ()) -> str:
    """The text of an expression in a user's names; names such as sqrt(b) are one symbol."""
    pattern = "".join(
        rf"(?<!\w){re.escape(n)}(?!\w)|" for n in sorted(names, key=len, reverse=True)
    )
    out: list[str] = []
    for token in re.findall(rf"{pattern}[<>]=|\*\*\d+|[^\W\d_]\w*|\d+|.", text):
        if token.startswith("**"):
            out[-1] = f"{{{out[-1].strip()}}}^{{{token[2:]}}} "
        elif token[0].isalpha():
            out.append(f"{symbol(token)} ")
        else:
            out.append({"*": r"\,", "<=": r"\leq ", ">=": r"\geq "}.get(token, token))
    return " ".join("".join(out).split())


def polynomial_rows(
    terms: Iterable[tuple[str, str, Sequence[int]]],
    variables: Sequence[str],
    names: Mapping[str, str],
) -> list[str]:
    r"""A polynomial in rows as wide as `ROOM`.

    Parameters
    ----------
    terms
        Sign, size of the coefficient as Python writes it, and exponents of each term.
    variables
        The variables of the exponents.
    names
        Their symbols.

    Examples
    --------
    >>> terms = [("+", "2", (1, 2)), ("-", "1", (0, 0))]
    >>> print(*polynomial_rows(terms, ("k", "z"), {"k": "k", "z": "z"}))
    2\,k\,{z}^{2} - 1
    """
    rows: list[str] = []
    row = ""
    for sign, size, exponents in terms:
        factors = [
            names[v] if e == 1 else f"{{{names[v]}}}^{{{e}}}"
            for v, e in zip(variables, exponents, strict=True)
            if e
        ]
        number = [scientific(size)] * (size != "1" or not factors)
        mark = f"{sign} " * bool(sign == "-" or row)
        part = mark + r"\,".join([*number, *factors])
        if row and width(row) + width(part) > ROOM:
            rows.append(row)
            row = part
        else:
            row = f"{row} {part}".strip()
    return [*rows, row or "0"]


WIDTHS = {"+": 1.25, "-": 1.25, "=": 1.35, ">": 1.35, "<": 1.35, " ": 0.0, "&": 0.0, "(": 0.45}
WIDTHS |= {")": 0.45, ",": 0.45, "|": 0.3, ".": 0.3, r"\,": 0.17, r"\;": 0.28, r"\quad": 1.0}
WIDTHS |= {rf"\{word}": 0.0 for word in "left right bigl bigr dot ddot mathit mathrm text".split()}
WIDTHS |= {rf"\{name}": 0.2 + 0.5 * len(name) for name in FUNCTIONS}
"""Widths of what is no letter [em]."""


def width(text: str) -> float:
    r"""The width of a formula in 10 pt, roughly [em].

    Examples
    --------
    >>> width(r"\frac{a + b}{2}") < width("a + b + c")
    True
    """
    return _width(iter(re.findall(r"\\[A-Za-z]+|\\.|.", text)))


def _width(tokens: Iterator[str]) -> float:
    """The width up to the end of a group."""
    size = 0.0
    for token in tokens:
        if token == "}":
            break
        if token == "{":
            size += _width(tokens)
        elif token in (r"\frac", r"\tfrac"):
            size += 0.25 + max(_argument(tokens), _argument(tokens))
        elif token in "^_":
            size += 0.7 * _argument(tokens)
        else:
            size += WIDTHS.get(token, 0.55)
    return size


def _argument(tokens: Iterator[str]) -> float:
    token = next(t for t in tokens if t != " ")
    return _width(tokens) if token == "{" else WIDTHS.get(token, 0.55)


def scientific(text: str) -> str:
    r"""A number as Python writes it, with its power of ten.

    Examples
    --------
    >>> print(scientific("0.25"), scientific("1e-09"))
    0.25 1\cdot10^{-9}
    """
    digits, mark, power = text.partition("e")
    return rf"{digits}\cdot10^{{{int(power)}}}" if mark else text


def escaped(text: str) -> str:
    r"""A text with the special characters of LaTeX replaced.

    Examples
    --------
    >>> print(escaped("a_1 & 50% of x**2"))
    a\_1 \& 50\% of x**2
    """
    table = {
        "\\": r"\textbackslash{}",
        "{": r"\{",
        "}": r"\}",
        "_": r"\_",
        "&": r"\&",
        "%": r"\%",
        "#": r"\#",
        "$": r"\$",
        "^": r"\^{}",
        "~": r"$\sim$",
        "<": "$<$",
        ">": "$>$",
        "λ": r"$\lambda$",
        "²": "$^2$",
        "…": r"\dots{}",
        "√": r"$\surd$",
    }
    table |= {sign: f"${SIGNS[sign].rstrip()}$" for sign in "≈≤≥→≠±·∞"}
    table |= {letter: rf"$\{word}$" for letter, word in GREEK_LETTERS.items()}

    def written(match: re.Match[str]) -> str:  # LaTeX reads other letters in UTF-8
        return rf"$\lambda^{{{match[1]}}}$" if match[1] else table.get(match[0], match[0])

    return breaking(re.sub(r"λ\^(\d+)|.", written, text, flags=re.DOTALL))


def breaking(text: str) -> str:
    """A text that may break within an exact number, which may be long."""
    return re.sub(r"(\d{9,}/)(?=\d)", r"\1\\allowbreak ", text)
