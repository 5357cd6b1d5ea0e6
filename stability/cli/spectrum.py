"""The command `spectrum`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.errors import ParameterError, absent, shown
from ..base.quantities import Kind
from ..bodies.thin_disk.disk_families import FAMILIES, leaning
from ..storage.json_text import json_text
from .options import _at, _disk, contact_of
from .subject.body_option import body_of, in_words, numbers_of_body, where_of
from .subject.system_option import own_family, place, with_at


def _spectrum(options: argparse.Namespace) -> None:
    body = body_of(options, {})
    family = own_family(options) if body is None else None
    if body is not None:
        record, head, result = _of_body(options, body)
    else:
        record, head, result = _of_disk(options) if family is None else _of_own(options, family)
    record |= {
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
    }
    record["unit"] = record.pop("unit")  # last
    if options.lean is not None:
        record["lean"] = options.lean
    if options.json:
        print(json_text(record))
        return
    print(head)
    print(f"verdict     {result.verdict.value}")
    print(f"nonlinear   {result.nonlinear.value}")
    print(f"reason      {result.reason}")
    print(f"eigenvalues [{record['unit']}]")
    for value, r, label in zip(result.eigenvalues, result.radius, result.modes.labels, strict=True):
        off = f"   within {r:.0e}" if result.certified else ""
        print(f"  {value.real + 0.0:+.12e} {value.imag + 0.0:+.12e}i{off}   {label}")


def _of_own(options: argparse.Namespace, family: Any) -> tuple[dict[str, Any], str, Any]:
    """First fields of the record, the first line of the text, and the spectrum."""
    from ..spectra.spectrum import spectrum

    given = with_at(options, family)
    missing = [n for n in (*family.at, *family.parameters) if n not in given]
    if missing:
        options_ = " ".join(f"--parameter {n}=NUMBER" for n in missing)
        raise ParameterError(f"{absent(missing)}; give {options_}.")
    at = [given[n] for n in family.at]
    others: Any = {n: given[n] for n in family.parameters}
    result = spectrum(
        family, at=at if len(at) > 1 else at[0], parameters=others,  # type: ignore[arg-type]
        certify=options.certify, escalate=not options.no_escalate,
    )  # fmt: skip
    record = {
        "system": family.system.name,
        "family": family.name,
        "parameters": {n: float(v) for n, v in others.items()},
        "at": {n: float(given[n]) for n in family.at},
        "unit": result.rate_unit,
    }
    ordered = {n: given[n] for n in (*family.at, *family.parameters)}
    return record, f"{family.system.name}, {family.name}, at {place(family, ordered)}", result


def _of_body(options: argparse.Namespace, body: Any) -> tuple[dict[str, Any], str, Any]:
    """As `_of_own`, for a body of revolution."""
    from ..bodies.round_body.families import FAMILIES as KNOWN
    from ..spectra.spectrum import spectrum

    contact = contact_of(options)
    where = where_of(options)
    at = None if options.at is None else _at(options.at)
    _check_count(options, at, KNOWN[options.family].at if options.family in KNOWN else ())
    result = spectrum(
        options.family, at=at, body=body, contact=contact, certify=options.certify,
        escalate=not options.no_escalate, **where,
    )  # fmt: skip
    parameters = numbers_of_body(body, contact)
    record = {
        "body": body.name,
        "family": options.family,
        "contact": contact.name,
        "parameters": parameters,
        "at": at,
        "unit": result.rate_unit,
    } | where
    member = zip(result.family.at, np.ravel(result.at), strict=True)
    told = ", ".join([*(f"{n} = {v:g}" for n, v in member), in_words(body, parameters)])
    return record, f"{options.family} of {body.name}, {contact.name} contact, at {told}", result


def _check_count(options: argparse.Namespace, at: Any, parts: Sequence[str]) -> None:
    """Refuse more or fewer numbers than name a member."""
    if parts and isinstance(at, list) and len(at) != len(parts):
        raise ParameterError(
            f"at is {shown(options.at)}; {options.family} takes {' and '.join(parts)}, "
            f"{len(parts)} number{'s' * (len(parts) > 1)}."
        )


def _of_disk(options: argparse.Namespace) -> tuple[dict[str, Any], str, Any]:
    """As `_of_own`, for the disk."""
    from ..spectra.spectrum import spectrum

    if (options.at is None) == (options.lean is None):
        raise ParameterError(f"give --at, or for {leaning()} --lean, and not both.")
    disk = _disk(options)
    contact = contact_of(options)
    at = None if options.at is None else _at(options.at)
    parts = FAMILIES[options.family].at if options.family in FAMILIES else ("at",)
    _check_count(options, at, parts)
    result = spectrum(
        options.family, at=at, lean=options.lean, disk=disk, contact=contact,
        certify=options.certify, escalate=not options.no_escalate,
    )  # fmt: skip
    parameters = {n: float(getattr(disk, n)) for n in ("mass", "radius", "k", "gravity")}
    parameters |= {n: float(v) for n, v in contact.given.items()}
    record = {
        "family": options.family,
        "contact": options.contact,
        "parameters": parameters,
        "at": at if at is not None else float(result.at[0]),
        "unit": Kind.GROWTH_RATE.label(dimensionless=disk.dimensionless),
    }
    given = at if isinstance(at, list) else [at]
    where = (
        [f"lean = {options.lean:.15g}"] if at is None
        else [f"{n} = {v:.15g}" for n, v in zip(parts, given, strict=True)]
    )  # fmt: skip
    rest = [
        f"{n} = {v:.15g}" for n, v in parameters.items()
        if n in ("k", *contact.given) or not disk.dimensionless
    ]  # fmt: skip
    head = f"{options.family}, {options.contact} contact, at {', '.join([*where, *rest])}"
    return record, head, result
