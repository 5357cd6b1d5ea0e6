"""The command `spectrum`."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

from .options import CERTIFY, FORMS, answer, check_form, flags
from .subject import CommandSubject, add_member, add_subject, doubles, options_subject

EXAMPLES = (
    "stability spectrum tumbling --at 0.5 --mu 0.3 --json",
    "stability spectrum spinning --body torus --tube 0.2 --at 2 --mu 0.3",
    "stability spectrum --system examples/bicycle.py:upright --at 5 --set g=9.81 --certify",
)
"""Examples of the help."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_subject(parser)
    add_member(parser)
    escalate = "leave undecided what double precision does not decide"
    flags(parser, {"--no-escalate": escalate, "--certify": CERTIFY, **FORMS})


def run(options: argparse.Namespace) -> None:
    """Print eigenvalues and verdict of one steady motion."""
    from ..spectra.spectrum import spectrum

    check_form(options)
    subject = options_subject(options)
    result = spectrum(
        subject.family,
        certify=options.certify,
        escalate=not options.no_escalate,
        **subject.arguments,
    )
    member = subject.member if "at" in subject.member else {"at": float(result.at[0])}
    record = {
        **subject.who,
        "parameters": doubles(subject.numbers),
        **(member | subject.member),
        "eigenvalues": [[float(v.real) + 0.0, float(v.imag) + 0.0] for v in result.eigenvalues],
        "structural_zeros": result.structural_zeros,
        "abscissa": result.abscissa + 0.0,
        "verdict": result.verdict.word,
        "nonlinear": result.nonlinear.word,
        "abscissa_error": result.abscissa_error,
        "certified": result.certified,
        "radius": list(result.radius),
        "modes": list(result.modes.labels),
        "reason": result.reason,
        "citation": result.citation,
        "unit": result.rate_unit,
    }
    forms = {"csv": result.to_csv, "latex": lambda: _latex(subject, result)}
    answer(options, record, _lines(subject, result), forms)


def _latex(subject: CommandSubject, result: Any) -> str:
    from ..tables.results import spectrum_table

    place = subject.place({**subject.at, **subject.numbers})
    return spectrum_table(result, f"{subject.title}, at {place}").to_latex()


def _lines(subject: CommandSubject, result: Any) -> Iterator[str]:
    yield f"{subject.title}, at {subject.place({**subject.at, **subject.numbers})}"
    if subject.law:
        yield f"law         {subject.law}"
    yield f"verdict     {result.verdict.value}"
    yield f"nonlinear   {result.nonlinear.value}"
    yield f"reason      {result.reason}"
    yield f"eigenvalues [{result.rate_unit}]"
    for value, r, label in zip(result.eigenvalues, result.radius, result.modes.labels, strict=True):
        off = f"   within {r:.0e}" if result.certified else ""
        yield f"  {value.real + 0.0:+.12e} {value.imag + 0.0:+.12e}i{off}   {label}"
