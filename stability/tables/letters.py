"""Text and formulas of the package in LaTeX."""

from __future__ import annotations

import re
import unicodedata

from ..base.quantities import KNOWN_UNIT, RAISED, Kind, readable
from ..derivation.latex import (
    FUNCTIONS,
    GREEK,
    GREEK_LETTERS,
    OF_DISK,
    SIGNS,
    breaking,
    escaped,
    scientific,
    symbol,
)

SYMBOLS = {n: OF_DISK[n] for n in ("mu", "phi_dot", "theta_dot", "omega3", "theta")} | {
    "lam": r"\lambda",
    "omega3_c": r"\omega_{3,c}",
    "vx": "v_{x}",
    "oo": r"\infty",
    "tilt0": r"\mathit{tilt}_{0}",
    "det": r"\det ",
}
"""Names of the package's formulas."""
ACCENTS = {"\u0307": "dot", "\u0308": "ddot", "\u0302": "hat"}
_SUPER, _SUB = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "₀₁₂₃₄₅₆₇₈₉"
_DIGITS = str.maketrans(_SUPER + _SUB, "0123456789-0123456789")
_TOKEN = re.compile(
    rf"(?P<arrow>->)|(?P<star>\b\w\w?\*(?=[²,;\s]|$))|(?P<accent>.[{''.join(ACCENTS)}])|(?P<greek>[\u0370-\u03ffµ])"
    r"|(?P<power>\*\*|\^)|(?P<name>[A-Za-z]+\d*(?:_[A-Za-z0-9]+)*)"
    r"|(?P<number>\d+(?:\.\d+)?(?:e[+-]?\d+)?)"
    rf"|(?P<super>[{_SUPER}]+)|(?P<sub>[{_SUB}]+)|(?P<space>\s+)|(?P<rest>.)"
)


def mathematics(text: str) -> str:
    r"""A formula in mathematics of LaTeX; lines may break at its signs, outside of roots.

    Parameters
    ----------
    text
        A formula as SymPy writes it, or with signs such as φ̇², √ and ≤.

    Examples
    --------
    >>> print(mathematics("-(2*k + 1)**2*sqrt(z)/mu**2"), mathematics("√(x_1) φ̇² ≤ sinθ"))
    -(2k+1)^{2}\sqrt{z}/\mu ^{2} \sqrt{x_{1}}\dot\varphi^{2}\le \sin \theta
    """
    text = text.replace(">=", "≥").replace("<=", "≤")
    tokens = [(m.lastgroup or "", m[0]) for m in _TOKEN.finditer(_decomposed(text))]
    return _typeset(tokens).strip()


def _decomposed(text: str) -> str:
    return "".join(unicodedata.normalize("NFD", c) if c.isalpha() else c for c in text)


def _typeset(tokens: list[tuple[str, str]]) -> str:
    out, at = "", 0
    while at < len(tokens):
        kind, word = tokens[at]
        at += 1
        if word in ("sqrt", "√"):
            inner, at = _operand(tokens, at)
            out += rf"\sqrt{{{inner}}}" if len(inner) < 60 else f"({inner})^{{1/2}}"
        elif kind == "power":
            inner, at = _operand(tokens, at)
            out += f"^{{{inner}}}"
        elif kind == "space" or word == "*":
            out += _space(tokens[max(at - 2, 0) : at - 1], tokens[at : at + 1])
        else:
            out += _typeset_token(kind, word)
    return breaking(out)


def _space(before: list[tuple[str, str]], after: list[tuple[str, str]]) -> str:
    """A thin space between two factors; a number and a bracket need none."""
    left, right = (before or [("", "")])[0], (after or [("", "")])[0]
    factors = ("greek", "name", "super", "sub", "accent")
    apart = left[0] in factors and (right[0] in (*factors, "number") or right[1] in ("√", "sqrt"))
    return r"\," if apart else ""


def _operand(tokens: list[tuple[str, str]], at: int) -> tuple[str, int]:
    """What a root or a power applies to: a bracket, or one word."""
    if at >= len(tokens):
        return "", at
    if tokens[at][1] != "(":
        return _typeset_token(*tokens[at]), at + 1
    depth = 0
    for end in range(at, len(tokens)):
        depth += {"(": 1, ")": -1}.get(tokens[end][1], 0)
        if depth == 0:
            return _typeset(tokens[at + 1 : end]), end + 1
    return "", at  # no bracket that closes: the sign stands alone


def _typeset_token(kind: str, word: str) -> str:
    if kind == "arrow":
        return r"\to "
    if kind == "star":  # mu* is the dimensionless coefficient
        return _name(word[:-1]).strip() + "_{*}"
    if kind == "accent":
        inner = GREEK_LETTERS.get(word[0])
        letter = f"\\{inner}".replace("\\phi", "\\varphi") if inner else word[0]
        return rf"\{ACCENTS[word[1]]}{letter if inner else '{' + letter + '}'}"
    if kind == "greek":
        return f"\\{GREEK_LETTERS[word]} ".replace("\\phi", "\\varphi")
    if kind == "super":
        return f"^{{{word.translate(_DIGITS)}}}"
    if kind == "sub":
        return f"_{{{word.translate(_DIGITS)}}}"
    if kind == "name":
        return _name(word)
    if kind == "number":
        return scientific(word)
    return SIGNS.get(word, word)


def _name(word: str) -> str:
    if word in SYMBOLS:
        return SYMBOLS[word] + (" " if SYMBOLS[word][-1].isalpha() else "")
    match = re.fullmatch(rf"(d?)({'|'.join(FUNCTIONS)})", word)
    if match:
        return rf"{match[1]}\{match[2]} "
    if len(word) == 2 and word.isalpha():  # a product, such as gR
        return word
    return symbol(word) + " " * (word in GREEK)


# --- sentences ---

SI = frozenset(readable(kind.si) for kind in Kind)
"""Units that may follow a value."""
UNITS = frozenset(kind.si for kind in Kind if "/" in kind.si) | {"uA/cm2", "m/s²"}
"""Units in a sentence that are no quotients of symbols: those of each kind, and a nerve's."""
_SIGN = re.compile(
    rf"[*^=<>\u2060≤≥≠²³√→∞±∂∈≈′|{_SUPER}{_SUB}\u0370-\u03ff]|_|[xyz0-9][{''.join(ACCENTS)}]|\w\["
)
_FREE = re.compile(r"[\d.,;:()+\-/=<>…·]+|->|A")
_OPERATOR = tuple("+-=<>≤≥≠·*/→")
_CODE = re.compile(r"[\w./-]+\.py(::\w+)?|\w+(/\w+){2,}")


def _mathy(word: str) -> bool:
    """Whether a word of a sentence is a part of a formula."""
    core = word.strip(",.;:()[]")
    if core in UNITS or not core or _CODE.fullmatch(core) or re.fullmatch(r"[A-Z]\.", word):
        return False
    if core in SYMBOLS and core not in ("det", "oo", "by") or len(core) == 1 and core.isalpha():
        return core not in ("a", "A", "I")
    if _SIGN.search(_decomposed(core)):
        return True
    letters = re.findall(r"[A-Za-z]+", core)
    digits = re.findall(r"\d+", core)
    named = all(len(x) <= 2 or x in (*SYMBOLS, *FUNCTIONS, "sqrt") for x in letters)
    short = named and all(len(x) <= 2 for x in digits)
    if letters and short and re.search(r"[/·+]|^-|\(", core):
        return True
    return bool(digits and letters and short) or bool(re.fullmatch(r"\d+(\.\d+)?e-?\d+", core))


def prose(text: str) -> str:
    r"""A sentence in LaTeX, with its formulas as mathematics that may break over lines.

    Parameters
    ----------
    text
        Plain text; formulas as SymPy writes them, or with signs such as φ̇² and ≤.

    Examples
    --------
    >>> print(prose("stable & neutral for 2*k*z - 1 > 0, as sinθ ≥ ε"))
    stable \& neutral for $2k\,z-1>0$, as $\sin \theta \ge \epsilon$
    """
    out: list[str] = []
    run: list[str] = []
    joined = re.sub(r"\ba (?==)|(?<== )a (?=\w+\^)", "\u2060a ", text)  # a symbol next to a sign
    for word in joined.split():
        if _mathy(word) or _FREE.fullmatch(word):
            if run and word[0] in "([" and not run[-1].endswith(_OPERATOR):
                out += _run(run)
                run = []
            run.append(word)
            if word[-1] not in ",;:.":
                continue
        elif run:
            out += _run(run)
            run = []
            out.append(_plain(word))
            continue
        else:
            out.append(_plain(word))
            continue
        out += _run(run)
        run = []
    return " ".join(out + _run(run))


def _run(words: list[str]) -> list[str]:
    """Words of a formula as mathematics; numbers and dashes at its ends are text."""
    first = next((i for i, w in enumerate(words) if _mathy(w)), len(words))
    last = max((i for i, w in enumerate(words) if _mathy(w)), default=-1)
    if first > last:
        return [_plain(w) for w in words]
    if words[last - 2 : last - 1] == ["="] and words[last].strip(",;:.") in SI:
        last -= 1  # the unit of a value is no factor
    while first and re.fullmatch(r"[(\-+]?[\d./]+|[-+=<>/A]", words[first - 1]):
        first -= 1
    while last + 1 < len(words) and re.fullmatch(r"[\d./]+[)\],;:.…]*|[-+=<>/A]", words[last + 1]):
        last += 1
    body = " ".join(words[first : last + 1])
    stop = re.search(r"[,;:.]*$", body)
    end = stop[0] if stop else ""
    body = body[: len(body) - len(end)]
    return [
        *(_plain(w) for w in words[:first]),
        f"${mathematics(body)}${end}",
        *(_plain(w) for w in words[last + 1 :]),
    ]


def _plain(word: str) -> str:
    core = word.strip(",;:()`")
    if _CODE.fullmatch(core.rstrip(".")):
        broken = re.sub(r"([/_.]|::)", r"\1\\allowbreak ", core.rstrip("."))
        return word.replace(core.rstrip("."), rf"\texttt{{{broken}}}").replace("_", r"\_")
    if (core := core.strip("[].")) in UNITS:
        return word.replace(core, unit(core))
    quoted = re.sub(r"^(\(?)`", r"\1@@", word).replace("`", "''")
    return escaped(quoted).replace("@@", "``")


def unit(text: str, *, dimensionless: bool = False) -> str:
    r"""A unit in LaTeX.

    Examples
    --------
    >>> print(unit("√(g/R)"), unit("m/s2"), unit("kg m^2"), unit("beat2"))
    $\sqrt{g/R}$ m/s$^{2}$ kg\,m$^{2}$ beat2
    """
    if "√" in text or dimensionless and text in ("R", "g", "m", "m g", "m g R"):
        return f"${mathematics(text)}$"
    plain = {raised: digit for digit, raised in RAISED.items()}
    parts = re.split(f"([{''.join(plain)}]+)", readable(text))
    parts[::2] = map(escaped, parts[::2])
    parts[1::2] = (f"$^{{{''.join(plain[c] for c in part)}}}$" for part in parts[1::2])
    words = re.findall(r"[^\W\d_]+", text)
    return "".join(parts).replace(" ", r"\," if all(map(KNOWN_UNIT.fullmatch, words)) else " ")


def number(text: str) -> str:
    r"""A formatted number in LaTeX; other words as text.

    Examples
    --------
    >>> print(number("1.1e-16"), number("-0.5"), number("-"), number("none"))
    $1.1\cdot10^{-16}$ $-0.5$ -- none
    """
    if text == "-":
        return "--"
    match = re.fullmatch(r"[+-]?\d*\.?\d+(e[+-]?\d+)?", text)
    return f"${scientific(text)}$" if match else escaped(text)
