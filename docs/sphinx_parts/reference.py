"""The reference: one page for each group of public names, in the order in which a reader meets them.

A name belongs to the group of its folder, so that a new name has a place without a list.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import stability

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
    Group("bodies", "Bodies and contact",
          "A disk, or another body of revolution; the law of its contact with the plane; "
          "resistance to rolling and turning.", ("bodies",)),
    Group("systems", "Systems",
          "Equations of motion of your own, and what they say about themselves.",
          ("systems.system", "systems.mechanics", "systems.condition")),
    Group("families", "Families",
          "Steady motions with a name, and how they are followed.",
          ("systems", "algebra.upright", "bodies.thin_disk")),
    Group("spectra", "Spectra and verdicts",
          "Eigenvalues of the linearisation, the verdict, and how it is known.",
          ("spectra", "base.verdict", "algebra", "derivation")),
    Group("boundaries", "Boundaries",
          "Where a verdict changes, what happens there, and what lies beyond linear theory.",
          ("boundary",)),
    Group("maps", "Maps", "Verdicts and growth rates over two quantities, in memory or in files.",
          ("maps",)),
    Group("motion", "Motion", "Launches: how each goes on, and how it ends.",
          ("motion", "bodies.launch", "integrators", "settling")),
    Group("scene", "Scenes", "The least model that answers a question, with its error.",
          ("scene",)),
    Group("basins", "Basins", "Which launch ends where, and how sensitive that is.", ("basin",)),
    Group("figures", "Figures", "Diagrams, loci, motions, films and live pages.",
          ("figures", "explorer")),
    Group("tables", "Tables and reports",
          "Tables of numbers, measured comparisons, and what to cite.",
          ("tables", "compare", "export", "base.citation", "atlas")),
    Group("errors", "Errors", "Every error is one sentence: the value, and what is accepted.",
          ("base",)),
)  # fmt: skip
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
    home: Mapping[str, tuple[str, ...]] = stability._HOME
    found: dict[str, list[str]] = {group.name: [] for group in GROUPS}
    for module, names in home.items():
        found[group_of(module).name] += names
    return found


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
        home = stability._WHERE[name]
        module = import_module(f"stability.{home}")
        text = documented(module, name)
        body = "\n".join(f"   {line}" if line else "" for line in text)
        return f"{head}.. py:data:: stability.{name}\n\n{body}\n\n"
    text = f"{head}.. auto{what}:: stability.{name}\n"
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
        written(TARGET / f"{group.name}.rst", f"{title}{body}")


# --- docstrings ---


def sections_of(lines: list[str]) -> list[str]:
    """A docstring whose line `Source: …` is a section of its own."""
    text = "\n".join(lines)
    text = re.sub(
        r"^Source: (.*?)(?=\n\s*\n|\Z)", r"Source\n------\n\1", text, flags=re.DOTALL | re.MULTILINE
    )
    return text.split("\n")


def sections(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:  # noqa: ARG001
    """Give every docstring its section `Source`, before its sections are read."""
    lines[:] = sections_of(lines)
