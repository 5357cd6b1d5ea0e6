"""Text and formulas of the package in LaTeX."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection

from ..base.quantities import KNOWN_UNIT, RAISED, Kind, readable
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
SYMBOLS = {
    name: re.sub(r"_(\w)$", r"_{\1}", QUANTITIES[name].latex)
    for name in ("mu", "phi_dot", "theta_dot", "omega3", "theta")
} | {
    "lam": r"\lambda",
    "omega3_c": r"\omega_{3,c}",
    "gn": "g_{n}",
    "vA": "v_{A}",
    "vx": "v_{x}",
    "bx": "b_{x}",
    "by": "b_{y}",
    "bz": "b_{z}",
    "Fx": "F_{x}",
    "Fy": "F_{y}",
    "oo": r"\infty",
    "tilt0": r"\mathrm{tilt}_{0}",
    "det": r"\det ",
    "pi": r"\pi",
}
"""Names of the package's formulas."""
FUNCTIONS = ("sin", "cos", "tan", "log", "ln", "exp")
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
            out += _one(kind, word)
    return _breaking(out)


def _breaking(text: str) -> str:
    """A text that may break within an exact number, which may be long."""
    return re.sub(r"(\d{9,}/)(?=\d)", r"\1\\allowbreak ", text)


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
        return _one(*tokens[at]), at + 1
    depth = 0
    for end in range(at, len(tokens)):
        depth += {"(": 1, ")": -1}.get(tokens[end][1], 0)
        if depth == 0:
            return _typeset(tokens[at + 1 : end]), end + 1
    return "", at  # no bracket that closes: the sign stands alone


def _one(kind: str, word: str) -> str:
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
    if kind == "number" and "e" in word:
        digits, _, power = word.partition("e")
        return rf"{digits}\cdot10^{{{int(power)}}}"
    return SIGNS.get(word, word)


def _name(word: str) -> str:
    if word in SYMBOLS:
        return SYMBOLS[word] + (" " if SYMBOLS[word][-1].isalpha() else "")
    if word in GREEK:
        return f"\\{word} "
    match = re.fullmatch(rf"(d?)({'|'.join(FUNCTIONS)})", word)
    if match:
        return rf"{match[1]}\{match[2]} "
    head, *subs = word.split("_")
    digits = re.fullmatch(r"([A-Za-z]+)(\d+)", head)
    if digits:
        head, subs = digits[1], [digits[2], *subs]
    letters = head if len(head) <= 2 else rf"\mathrm{{{head}}}"
    return letters + (f"_{{{','.join(subs)}}}" if subs else "")


# --- names of a user's system ---


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
    match = re.fullmatch(r"([^\W\d_]\w*)\((.*)\)", name)
    if match:
        inner = converted(match[2])
        if match[1] == "sqrt":
            return rf"\sqrt{{{inner}}}"
        known = match[1] in ("sin", "cos", "tan", "exp", "log", "sinh", "cosh", "tanh")
        head = f"\\{match[1]}" if known else rf"\mathrm{{{match[1]}}}"
        return rf"{head}\left({inner}\right)"
    first, *rest = [p for p in name.split("_") if p] or ["x"]
    digits = re.fullmatch(r"([A-Za-z]+)(\d+)", first)
    if digits:
        first, rest = digits[1], [digits[2], *rest]
    head = _letter(first)
    return head + (f"_{{{','.join(_letter(r) for r in rest)}}}" if rest else "")


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
    known = "".join(rf"(?<!\w){re.escape(n)}(?!\w)|" for n in sorted(names, key=len, reverse=True))
    out: list[str] = []
    for token in re.findall(rf"{known}[<>]=|\*\*\d+|[^\W\d_]\w*|\d+|.", text):
        if token.startswith("**"):
            out[-1] = f"{{{out[-1].strip()}}}^{{{token[2:]}}} "
        elif token[0].isalpha():
            out.append(f"{symbol(token)} ")
        else:
            out.append({"*": r"\,", "<=": r"\leq ", ">=": r"\geq "}.get(token, token))
    return " ".join("".join(out).split())


# --- sentences ---

UNITS = frozenset(kind.si for kind in Kind if "/" in kind.si) | {"uA/cm2"}
"""Units in a sentence that are no quotients of symbols: those of each kind, and a nerve's."""
_SIGN = re.compile(
    rf"[*^=<>\u2060≤≥≠²³√→∞±∂∈≈′|{_SUPER}{_SUB}\u0370-\u03ff]|_|[xyz0-9][{''.join(ACCENTS)}]|\w\["
)
_NEXT_TO_SIGN = re.compile(
    r"(?<![\w/])(A|by)(?= [+=<>≤≥-] )|(?<= [+=<>≤≥-] )(A|by)(?![\w/])(?! [a-z]{2})"
    r"|(?<= of )A\b|\bA(?= has )"
)
"""Words of English that are symbols next to a sign."""
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
    joined = re.sub(r"\b(sin|cos) a\b", "\\1\u2060a", text)
    joined = re.sub(r"\ba (?==)|(?<== )a (?=\w+\^)", "\u2060a ", joined)
    joined = _NEXT_TO_SIGN.sub("\u2060\\g<0>", joined)
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
    found = "".join(table.get(c, c) for c in text)  # LaTeX reads other letters in UTF-8
    return _breaking(found)


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
    match = re.fullmatch(r"([+-]?)(\d*\.?\d+)(?:e([+-]?\d+))?", text)
    if not match:
        return escaped(text)
    power = rf"\cdot10^{{{int(match[3])}}}" if match[3] else ""
    return f"${match[1]}{match[2]}{power}$"
