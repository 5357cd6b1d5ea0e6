"""The reference: a page for each group of public names, in the order in which a reader meets them.

A name belongs to the group of its folder, so that a new name has a place without a list.
"""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import stability
from stability.base.lazy import HOMES

from .notebooks import written

TARGET = Path(__file__).resolve().parents[1] / "reference"


@dataclass(frozen=True)
class Group:
    """A page of the reference."""

    name: str
    """Name of the file."""
    title: str
    """Title of the page."""
    words: str
    """What the group is for, in a sentence or two."""
    rooms: tuple[str, ...]
    """Folders or modules of the package whose public names are here."""


GROUPS = (
    Group(
        "bodies",
        "Bodies and contact",
        "A disk, or another body of revolution; the law of its contact with the plane; "
        "resistance to rolling and turning.",
        ("bodies",),
    ),
    Group(
        "systems",
        "Systems",
        "Equations of motion of your own, and what they say about themselves.",
        ("systems.system", "systems.mechanics", "systems.linear", "systems.condition"),
    ),
    Group(
        "families",
        "Families",
        "Steady motions with a name, and how they are followed.",
        ("systems", "algebra.upright", "bodies.thin_disk"),
    ),
    Group(
        "spectra",
        "Spectra and verdicts",
        "Eigenvalues of the linearisation, the verdict, and how it is known.",
        ("spectra", "base.verdict", "algebra", "derivation"),
    ),
    Group(
        "boundaries",
        "Boundaries",
        "Where a verdict changes, what happens there, and what lies beyond linear theory.",
        ("boundary",),
    ),
    Group(
        "maps",
        "Maps",
        "Verdicts and growth rates over two quantities, in memory or in files.",
        ("maps",),
    ),
    Group(
        "motion",
        "Motion",
        "Launches: how each goes on, and how it ends.",
        ("motion", "bodies.launch", "integrators", "settling"),
    ),
    Group(
        "scene", "Scenes", "The least model that answers a question, with its error.", ("scene",)
    ),
    Group("basins", "Basins", "Which launch ends where, and how sensitive that is.", ("basin",)),
    Group(
        "figures",
        "Figures",
        "Diagrams, loci, motions, films and live pages.",
        ("figures", "explorer"),
    ),
    Group(
        "tables",
        "Tables and reports",
        "Tables of numbers, measured comparisons, and what to cite.",
        ("tables", "compare", "export", "base.citation", "atlas"),
    ),
    Group(
        "errors",
        "Errors",
        "Every error is one sentence: the value, and what is accepted.",
        ("base",),
    ),
)
"""The pages, in their order."""


def group_of(module: str) -> Group:
    """The group of a module of the package: that with the longest room around it.

    Parameters
    ----------
    module
        Name of a module, within the package.

    Raises
    ------
    ValueError
        If no group has a room for it.
    """
    fitting = [
        (len(room), index, group)
        for index, group in enumerate(GROUPS)
        for room in group.rooms
        if f"{module}.".startswith(f"{room}.")
    ]
    if not fitting:
        raise ValueError(f"no group of the reference has a room for {module}: see {__file__}")
    return max(fitting, key=lambda found: found[:2])[2]


def grouped() -> dict[str, list[str]]:
    """The public names of each group, in the order of the face."""
    names: dict[str, list[str]] = {group.name: [] for group in GROUPS}
    for name in sorted(HOMES, key=lambda name: (place(name).count("."), name.lower())):
        names[group_of(HOMES[name].partition(".")[2]).name].append(name)
    return names


def place(name: str) -> str:
    """The name with the module in which users find it."""
    rooms = (stability, stability.results, stability.export, stability.statistics)
    return next(f"{room.__name__}.{name}" for room in rooms if name in room.__all__)


def kind(name: str) -> str:
    """How autodoc documents a name."""
    value = getattr(stability, name)
    if isinstance(value, type):
        return "exception" if issubclass(value, BaseException) else "class"
    return "function" if callable(value) else "data"


def entry(name: str) -> str:
    """The text of one name."""
    what = kind(name)
    head = f"{name}\n{'-' * len(name)}\n\n"
    if what == "data":
        module = import_module(HOMES[name])
        text = documented(module, name)
        body = "\n".join(f"   {line}" if line else "" for line in text)
        return f"{head}.. py:data:: {place(name)}\n\n{body}\n\n"
    text = f"{head}.. auto{what}:: {place(name)}\n"
    if what == "class":
        text += "   :members:\n   :show-inheritance:\n"
        if not _enumeration(name):
            text += "   :inherited-members: object, Record, Enum, Mapping, Sequence, tuple, str\n"
    return text + "\n"


def _enumeration(name: str) -> bool:
    from enum import Enum

    return issubclass(getattr(stability, name), Enum)


def documented(module: Any, name: str) -> list[str]:
    """The docstring of a constant, from below it in its module."""
    from sphinx.pycode import ModuleAnalyzer

    docs = ModuleAnalyzer.for_module(module.__name__).find_attr_docs()
    if ("", name) in docs:
        return sections_of(docs["", name])
    return sections_of((getattr(module, name).__doc__ or "").splitlines())


def write() -> None:
    """Write the pages."""
    names = grouped()
    for group in GROUPS:
        title = f"{group.title}\n{'=' * len(group.title)}\n\n{group.words}\n\n"
        body = "\n".join(entry(name) for name in names[group.name])
        written(TARGET / f"{group.name}.rst", f"{title}{body}{_errors(group)}")


def _errors(group: Group) -> str:
    """The kinds of error that functions raise, all of them kinds of `StabilityError`."""
    from stability.base import errors

    if group.name != "errors":
        return ""
    base = errors.StabilityError
    found = {n: v for n, v in vars(errors).items() if isinstance(v, type)}
    kinds = [n for n, v in found.items() if issubclass(v, base) and v is not base]
    head = "\nKinds of StabilityError\n-----------------------\n\n"
    head += "Catch `StabilityError`, which all of these are, or one of them.\n\n"
    head = head.replace("`StabilityError`", ":py:exc:`stability.StabilityError`")
    return head + "".join(
        f".. autoexception:: stability.base.errors.{name}\n   :show-inheritance:\n\n"
        for name in kinds
    )


# --- docstrings ---


def sections_of(lines: list[str]) -> list[str]:
    """A docstring in the markup of Sphinx: names are links, and `Source: …` is a section."""
    text = "\n".join(lines)
    text = re.sub(
        r"^Source: (.*?)(?=\n\s*\n|\Z)",
        r"Source\n------\n\1",
        text,
        flags=re.DOTALL | re.MULTILINE,
    )
    text = re.sub(
        r"^Attributes\n-+\n(.*?)(?=\n\s*\n|\Z)", _attributes, text, flags=re.DOTALL | re.MULTILINE
    )
    lines, example = [], False
    for line in text.split("\n"):
        example = line.lstrip().startswith(">>>") or (example and bool(line.strip()))
        lines.append(line if example or "``" in line else line.replace("|", r"\|"))
    text = "\n".join(lines)
    name = r"(?<![`:\w])`([^`\n]+(?:\n *[^`\s][^`\n]*)?)`(?![`_])(.?)"
    return re.sub(name, _marked, text).split("\n")


def _attributes(match: re.Match[str]) -> str:
    """The attributes of a class as a list; `a, b` on one line would else be a name and its type."""
    lines = [
        line if line.startswith(" ") else ", ".join(f"``{n}``" for n in line.split(", "))
        for line in match[1].split("\n")
    ]
    return ".. rubric:: Attributes\n\n" + "\n".join(lines)


def _marked(match: re.Match[str]) -> str:
    """A public name as a link, anything else as code."""
    name, after = re.sub(r"\n *", " ", match[1]).replace("\\", ""), match[2]
    gap = "\\ " if after and not re.match(r"[\s.,:;!?)\]}'\"/-]", after) else ""
    if name in HOMES:
        return f":py:obj:`~{place(name)}`{gap}{after}"
    return f"``{name}``{gap}{after}"


def sections(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Read the sections of a docstring; those of attributes are plain text."""
    from sphinx.ext.napoleon import NumpyDocstring

    lines[:] = sections_of(lines)
    if what not in ("attribute", "property", "data"):
        lines[:] = NumpyDocstring(lines, app.config, app, what, name, obj, options).lines()


def alone(app: Any) -> None:
    """Keep the general reader of docstrings away: it takes words before a colon for a type."""
    from sphinx.ext import napoleon

    for listener in list(app.events.listeners["autodoc-process-docstring"]):
        if listener.handler is napoleon._process_docstring:
            app.disconnect(listener.id)


def defaults(
    _app: Any,
    _what: str,
    _name: str,
    thing: Any,
    _options: Any,
    signature: str | None,
    returned: str | None,
) -> tuple[str, str | None] | None:
    """A signature with numbers and words in the places of the constants that name them."""
    if not signature:
        return None
    scope = vars(sys.modules[getattr(thing, "__module__", "stability")])

    def value(match: re.Match[str]) -> str:
        found: Any = scope.get(match.group(2))
        for name in (match.group(3) or "").split(".")[1:]:
            found = getattr(found, name, None)
        plain = isinstance(found, int | float | str | tuple)
        return f"{match.group(1)}{found!r}" if plain else match.group(0)

    shown = re.sub(r"(= ?)([A-Z]\w*)((?:\.\w+)*)(?=[,)])", value, signature)
    return shown, returned


def resolved(app: Any, env: Any, node: Any, inner: Any) -> Any:  # noqa: ARG001
    """The place of an error that is raised and has no public name: the page on errors."""
    from docutils import nodes

    from stability.base import errors

    name = node.get("reftarget", "").rpartition(".")[2]
    found = getattr(errors, name, None)
    if not isinstance(found, type) or not issubclass(found, errors.StabilityError):
        return None
    target = app.builder.get_relative_uri(node["refdoc"], "reference/errors")
    link = nodes.reference("", "", refuri=f"{target}#stability.base.errors.{name}", internal=True)
    link += inner
    return link
