"""Names of states and parameters as symbols of LaTeX."""

from __future__ import annotations

import re
from collections.abc import Iterable

from ..bodies.quantities import QUANTITIES

GREEK = (
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau phi "
    "chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi Omega"
).split()
"""Letters by their names, as LaTeX has them."""
OWN = {
    name: re.sub(r"_(\w)$", r"_{\1}", QUANTITIES[name].latex)
    for name in ("mu", "phi_dot", "theta_dot", "omega3", "theta", "slip_x", "slip_y")
    if name in QUANTITIES and QUANTITIES[name].latex
}
"""Symbols of the disk."""
FUNCTIONS = ("sin", "cos", "tan", "exp", "log", "sinh", "cosh", "tanh")
"""Functions with a name of their own in LaTeX."""


def symbols(names: Iterable[str]) -> dict[str, str]:
    r"""A symbol for each name; two names never share one.

    Parameters
    ----------
    names
        Names of states, parameters and unknowns.

    Examples
    --------
    >>> symbols(["theta", "x_1", "speed", "sin(theta)"])["sin(theta)"]
    '\\sin\\left(\\theta\\right)'
    >>> list(symbols(["q1", "q_1"]).values())
    ['q_{1}', '\\mathit{q\\_1}']
    """
    found: dict[str, str] = {}
    for name in dict.fromkeys(names):
        made = symbol(name)
        if made in found.values():
            made = _plain(name)
        found[name] = made
    return found


def symbol(name: str) -> str:
    r"""One name in mathematics of LaTeX.

    Parameters
    ----------
    name
        Name such as `phi_dot`, `x_1` or `sqrt(b)`.

    Examples
    --------
    >>> print(symbol("omega_0"), symbol("sqrt(b)"), symbol("dtheta"))
    \omega_{0} \sqrt{b} \mathit{dtheta}
    """
    if name in OWN:
        return OWN[name]
    call = re.fullmatch(r"([a-z]\w*)\((.*)\)", name)
    if call and call[1] == "sqrt":
        return rf"\sqrt{{{symbol(call[2])}}}"
    if call and call[1] in FUNCTIONS:
        return rf"\{call[1]}\left({symbol(call[2])}\right)"
    dotted = re.fullmatch(r"(\w+)_dot", name)
    if dotted:
        return rf"\dot{{{symbol(dotted[1])}}}"
    parts = re.fullmatch(r"([A-Za-z]+?)_?(\d+|(?<=_)[A-Za-z]+)", name)
    if parts and (len(parts[1]) == 1 or parts[1] in GREEK):
        return f"{_letter(parts[1])}_{{{_letter(parts[2])}}}"
    return _letter(name)


def _letter(word: str) -> str:
    if word in GREEK:
        return f"\\{word}"
    return word if len(word) == 1 and word.isalpha() or word.isdigit() else _plain(word)


def _plain(name: str) -> str:
    """The name itself, with every sign that LaTeX would read."""
    safe = "".join(c if c.isascii() and c.isalnum() else r"\_" for c in name)
    return rf"\mathit{{{safe}}}"
