"""The command `spectrum`."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from ..storage.text import json_text
from .subject import Subject, members


def _spectrum(options: argparse.Namespace) -> None:
    from ..spectra.spectrum import spectrum

    subject = members(options)
    result = spectrum(
        subject.family,
        certify=options.certify,
        escalate=not options.no_escalate,
        **subject.arguments,
    )
    record = {
        **subject.who,
        **_member(options, subject, result),
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
    if options.json:
        print(json_text(record))
        return
    print(f"{subject.title}, at {_place(options, subject, result)}")
    print(f"verdict     {result.verdict.value}")
    print(f"nonlinear   {result.nonlinear.value}")
    print(f"reason      {result.reason}")
    print(f"eigenvalues [{record['unit']}]")
    for value, r, label in zip(result.eigenvalues, result.radius, result.modes.labels, strict=True):
        off = f"   within {r:.0e}" if result.certified else ""
        print(f"  {value.real + 0.0:+.12e} {value.imag + 0.0:+.12e}i{off}   {label}")


def _member(options: argparse.Namespace, subject: Subject, result: Any) -> dict[str, Any]:
    """The member and all numbers, for the record."""
    numbers = subject.numbers
    if subject.thing is None:
        names = subject.family.at
        return {
            "parameters": {n: v for n, v in numbers.items() if n not in names},
            "at": {n: numbers[n] for n in names},
        }
    at = subject.arguments["at"]
    if at is None:  # named by its lean
        return {"parameters": numbers, "at": float(result.at[0]), "lean": options.lean}
    where = {n: v for n, v in subject.arguments.items() if n in ("theta", "pole")}
    return {"parameters": numbers, "at": at, **where}


def _place(options: argparse.Namespace, subject: Subject, result: Any) -> str:
    """The member and all numbers in words."""
    if subject.thing is None:
        return subject.place(subject.arguments["parameters"])
    named = dict(zip(result.family.at, np.ravel(result.at), strict=True))
    if subject.arguments["at"] is None:
        named = {"lean": options.lean}
    return subject.place({**named, **subject.numbers})
