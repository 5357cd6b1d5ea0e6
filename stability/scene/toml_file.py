"""A scene in a TOML file: its tables, each key checked, as arguments of `Scene`.

A file holds a start, one law or several, and a question.  What it leaves out has the default of
`Scene`.  What it has too much is refused, so that a name that is mistyped is never ignored.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Collection, Mapping
from inspect import signature
from pathlib import Path
from typing import Any

from ..base.checks import instance, one_number
from ..base.errors import FileError, NameUnknownError, ParameterError, StabilityError, shown
from ..bodies.contact_laws import Contact, class_named, law_named
from ..bodies.disk import Disk
from ..bodies.launch import launch
from ..bodies.newton_euler import STATES
from ..bodies.quantities import PHYSICAL
from ..bodies.resistance import RESISTANCES
from ..bodies.round_body.body import Body
from ..bodies.round_body.shape import SCALES
from ..bodies.round_body.shapes.named import NAMED
from ..storage.targets import path_text, place, refusing

TABLES = ("title", "disk", "body", "contact", "start", "resistance", "question", "uncertain")
"""What a file may hold at its top."""
LAUNCH = ("family", "at", "tilt")
"""Keys of a start near a steady motion."""
WHICH = ("theta", "pole")
"""Further keys of a start near a steady motion of a body."""
NUMBERS = ("horizon", "tolerance", "flat", "max_seconds")
"""Keys of a question whose values are numbers."""
QUESTION = (*NUMBERS, "quantities", "raise_tolerance")
"""Keys of a question."""
LARGEST = 2**20
"""Most bytes of a file."""


def read(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The arguments of `Scene` that a TOML file states.

    Parameters
    ----------
    path
        The file; its tables are those of `examples/scenes`.

    Returns
    -------
    dict
        Keyword arguments of `Scene` by name.

    Raises
    ------
    StabilityError
        In one sentence, if the file cannot be read, is not TOML, or states what is not accepted.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "rolled.toml"
    ...     _ = file.write_text('''
    ...         contact = {law = "viscous", mu = 300.0}
    ...         start = {family = "rolling", at = 1.2, tilt = 1e-3}
    ...         question = {horizon = 1000.0, quantities = ["outcome"]}
    ...     ''')
    ...     given = read(file)
    >>> given["contact"].mu, given["horizon"], given["quantities"]
    (300.0, 1000.0, ('outcome',))
    """
    return titled(path)[1]


def titled(path: str | os.PathLike[str]) -> tuple[str, dict[str, Any]]:
    """The title of a file, and the arguments of `Scene` that it states.

    Parameters
    ----------
    path
        The file, as for `read`.

    Returns
    -------
    title, arguments
        The title, which is the name of the file where it states none; keyword arguments of
        `Scene` by name.
    """
    source = place(path)
    tables = _tables(source)
    try:
        title = instance("title", tables.get("title", source.stem), str, "give a text")
        return title, _arguments(tables)
    except StabilityError as error:
        raise type(error)(f"{path_text(source.name)}: {error}") from None


def _tables(source: Path) -> dict[str, Any]:
    """What a file holds, refused in a sentence where it is not TOML or has nothing."""
    with refusing(source, "read"):
        if not source.is_file():
            raise FileError(f"{path_text(source)} is not a file; give a scene as a TOML file.")
        with source.open("rb") as file:
            raw = file.read(LARGEST + 1)
    if len(raw) > LARGEST:
        raise FileError(f"{path_text(source)} has more than {LARGEST >> 20} MiB; it is no scene.")
    try:
        tables = tomllib.loads(raw.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = raw[: error.start].count(b"\n") + 1
        raise FileError(
            f"{path_text(source)} is not UTF-8 text (at line {line}); save it as UTF-8."
        ) from None
    except tomllib.TOMLDecodeError as error:
        last = f"at line {len(raw.splitlines())}, the last"
        why = str(error).replace("at end of document", last)
        raise FileError(f"{path_text(source)} is not TOML: {why}.") from None
    except (RecursionError, ValueError):  # nested too deeply; more digits than Python converts
        raise FileError(
            f"{path_text(source)} is not TOML that can be read: its values are nested too deeply "
            "or have too many digits."
        ) from None
    if not tables:
        raise FileError(
            f"{path_text(source)} is empty; a scene needs the tables [contact], [start] and "
            "[question]."
        )
    return tables


def _arguments(tables: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of `Scene`, from the tables of a file."""
    _only(tables, TABLES, "the file")
    for name in ("contact", "start", "question"):
        if name not in tables:
            raise ParameterError(f"[{name}] is missing; a scene needs this table.")
    for name in tables.keys() - {"title"}:
        _table(tables[name], name)
    if "disk" in tables and "body" in tables:
        raise ParameterError("[disk] and [body] are both given; give one of them.")
    disk: Any = _body(tables["body"]) if "body" in tables else _disk(tables.get("disk", {}))
    arguments = {
        "disk": disk,
        **_laws(tables["contact"]),
        "start": _start(tables["start"], disk, WHICH if "body" in tables else ()),
        **_question(tables["question"]),
    }
    if "resistance" in tables:
        _only(tables["resistance"], tuple(RESISTANCES), "[resistance]")
        values = _numbers(tables["resistance"], "resistance")
        arguments["resistance"] = [RESISTANCES[n](value) for n, value in values.items()]
    if "uncertain" in tables:
        arguments["uncertain"] = _numbers(tables["uncertain"], "uncertain")
    return arguments


def _disk(table: Mapping[str, Any]) -> Disk:
    _only(table, ("name", *PHYSICAL, "k"), "[disk]")
    if "name" in table:
        if len(table) > 1:
            other = next(n for n in table if n != "name")
            raise ParameterError(f"[disk] has name and {other}; a disk with a name has its own.")
        return Disk.named(instance("name of [disk]", table["name"], str, "give a text"))
    return Disk(**_numbers(table, "disk"))


def _body(table: Mapping[str, Any]) -> Body:
    """A named body with its numbers."""
    if "name" not in table:
        raise ParameterError(f"[body] has no name; give one of {', '.join(NAMED)}.")
    word = instance("name of [body]", table["name"], str, "give a text")
    if word not in NAMED:
        raise NameUnknownError(f"[body] names {shown(word)}; known are {', '.join(NAMED)}.")
    every = {n: p for n, p in signature(NAMED[word]).parameters.items() if p.kind != p.VAR_KEYWORD}
    _only(table, ("name", *every, *SCALES), f"[body] of the {word}")
    for name, parameter in every.items():
        if parameter.default is parameter.empty and name not in table:
            raise ParameterError(f"[body] has no {name}; the {word} needs it.")
    flags = {n: v for n, v in table.items() if isinstance(v, bool)}
    return NAMED[word](
        **_numbers({n: v for n, v in table.items() if n not in ("name", *flags)}, "body"), **flags
    )


def _laws(table: Mapping[str, Any]) -> dict[str, Any]:
    """One law, or laws by name where each entry is a table, with their weights."""
    inner = [n for n, value in table.items() if isinstance(value, Mapping)]
    if not inner:
        return {"contact": _law(table, "contact")}
    if len(inner) < len(table):
        other = next(n for n in table if n not in inner)
        raise ParameterError(
            f"[contact] has {shown(other)} and the table {shown(inner[0])}; give one law, or each "
            "law in a table [contact.NAME]."
        )
    weights = {n: table[n]["weight"] for n in inner if "weight" in table[n]}
    every = {n: {k: v for k, v in table[n].items() if k != "weight"} for n in inner}
    laws = {n: _law({"law": n, **entry}, f"contact.{n}") for n, entry in every.items()}
    if weights and len(weights) < len(inner):
        lost = next(n for n in inner if n not in weights)
        raise ParameterError(f"[contact.{lost}] has no weight; give one for each law, or for none.")
    return {"contact": laws} | ({"weights": weights} if weights else {})


def _law(table: Mapping[str, Any], where: str) -> Contact:
    """A law and its parameters; the first two checks speak of a file, not of options."""
    if "law" not in table:
        raise ParameterError(f'[{where}] has no law; give one, such as law = "viscous".')
    law = class_named(instance(f"law of [{where}]", table["law"], str, "give a text"), motion=True)
    names = [p.name for p in law.parameters]
    _only(table, ("law", *names), f"[{where}] with the {law.name} law")
    values = _numbers({n: v for n, v in table.items() if n != "law"}, where)
    for name in names:
        others = law.alternatives(name)
        if not set(others) & set(values):
            raise ParameterError(
                f"[{where}] has no {' or '.join(others)}; the {law.name} law needs a positive "
                f"number, such as {others[-1]} = 0.3."
            )
    return law_named(table["law"], values.pop("mu", None), motion=True, others=values)


def _start(table: Mapping[str, Any], disk: Disk | Body, which: Collection[str]) -> Any:
    """The states by name, or the six of a launch near a steady motion, which may need `which`."""
    _only(table, (*STATES, *LAUNCH, *which), "[start]")
    if not set(LAUNCH) & set(table):
        if "theta" not in table:
            raise ParameterError("[start] has no theta; give it, or a family with at and tilt.")
        return _numbers(table, "start")
    both = next((n for n in STATES if n in table and n not in which), None)
    if both is not None:
        mine = next(n for n in LAUNCH if n in table)
        raise ParameterError(
            f"[start] has {mine} and {both}; give the states, or a family with at and tilt."
        )
    for name in ("family", "at"):
        if name not in table:
            raise ParameterError(f"[start] has no {name}; a launch needs a family and at.")
    words = {n: table[n] for n in ("pole",) if n in table}
    values: dict[str, Any] = _numbers(
        {n: v for n, v in table.items() if n not in ("family", *words)}, "start"
    )
    return launch(table["family"], body=disk, **values, **words)


def _question(table: Mapping[str, Any]) -> dict[str, Any]:
    _only(table, QUESTION, "[question]")
    if "horizon" not in table:
        raise ParameterError("[question] has no horizon; give the last time of interest.")
    arguments: dict[str, Any] = _numbers({n: table[n] for n in NUMBERS if n in table}, "question")
    if "raise_tolerance" in table:
        raised = table["raise_tolerance"]
        arguments["raise_tolerance"] = instance(
            "raise_tolerance of [question]", raised, bool, "give true or false"
        )
    if "quantities" in table:
        asked = table["quantities"]
        every = (asked,) if isinstance(asked, str) else asked
        if not isinstance(every, (list, tuple)) or not all(isinstance(n, str) for n in every):
            raise ParameterError(
                f"quantities of [question] is {shown(asked)}; give names, such as "
                '["outcome", "final"].'
            )
        arguments["quantities"] = tuple(every)
    return arguments


def _only(table: Mapping[str, Any], names: Collection[str], where: str) -> None:
    """Refuse a key that is not known."""
    for name in table:
        if name not in names:
            raise NameUnknownError(f"{where} has {shown(name)}; known are {', '.join(names)}.")


def _table(value: Any, name: str) -> None:
    if not isinstance(value, Mapping):
        raise ParameterError(f"{name} is {shown(value)}; give a table, under a line [{name}].")


def _numbers(table: Mapping[str, Any], where: str) -> dict[str, float]:
    """All values of a table as finite numbers."""
    return {n: one_number(f"{n} of [{where}]", value) for n, value in table.items()}
