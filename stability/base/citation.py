"""What to cite: works, their keys by what a call has used, and `citation`."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from importlib.resources import files
from typing import Any

from .above import function_of
from .errors import ParameterError, shown
from .types import Record
from .version import __version__


@dataclass(frozen=True)
class CitedWork:
    """A paper, book, or program, as an entry of BibTeX.

    Examples
    --------
    >>> WORKS["heyoka"].text
    'F. Biscani and D. Izzo, Revisiting high-order Taylor methods for astrodynamics and celestial mechanics, Monthly Notices of the Royal Astronomical Society 504(2), 2614-2628, 2021, doi:10.1093/mnras/stab1032'
    """  # noqa: E501

    key: str
    """Key of the entry."""
    kind: str
    """article, book, inproceedings, misc or software."""
    role: str
    """What it is cited for."""
    author: str
    """Authors, joined by `and`, as BibTeX takes them."""
    title: str
    """Title."""
    year: str = ""
    """Year; empty for a program without one."""
    place: str = ""
    """Journal, publisher, or proceedings."""
    volume: str = ""
    """Volume, with the number in brackets."""
    pages: str = ""
    """First and last page."""
    url: str = ""
    """Address of a program's page."""
    doi: str = ""
    """DOI."""

    @property
    def text(self) -> str:
        """The work in one line."""
        people = [_forward(name) for name in self.author.strip("{}").split(" and ")]
        many = ", ".join(people[:-1]) + " and " + people[-1] if len(people) > 1 else people[0]
        where = " ".join(filter(None, [self.place, self.volume]))
        parts = [many, self.title, where, self.pages.replace("--", "-"), self.year]
        parts += [self.url, self.doi and f"doi:{self.doi}"]
        return ", ".join(filter(None, parts))

    @property
    def bibtex(self) -> str:
        """The entry of BibTeX."""
        volume, _, number = self.volume.partition("(")
        where = {
            "article": "journal",
            "book": "publisher",
            "inproceedings": "booktitle",
            "misc": "note",
            "software": "note",
        }[self.kind]
        fields = {
            "author": self.author,
            "title": f"{{{self.title}}}",
            where: self.place,
            "volume": volume,
            "number": number.strip(")"),
            "pages": self.pages,
            "year": self.year,
            "url": self.url,
            "doi": self.doi,
        }
        lines = [f"  {name} = {{{_latex(value)}}}" for name, value in fields.items() if value]
        kind = "misc" if self.kind == "software" else self.kind
        return f"@{kind}{{{self.key},\n" + ",\n".join(lines) + "\n}"


def _forward(name: str) -> str:
    """`Last, First` as `F. Last`."""
    last, _, first = name.partition(", ")
    initials = " ".join(f"{word[0]}." for word in re.split(r"[ -]", first) if word)
    return f"{initials} {last}".strip()


def _latex(text: str) -> str:
    return text.replace("&", r"\&").replace("ø", r"{\o}")


def _read() -> dict[str, CitedWork]:
    text = files(__package__).joinpath("works.json").read_text(encoding="utf-8")
    works = {entry["key"]: CitedWork(**entry) for entry in json.loads(text)}
    works["stability"] = replace(works["stability"], place=f"version {__version__}")
    return works


WORKS = _read()
"""Every work by its key."""


MODEL = "stability, przybylska2016"
"""What is cited without a computation: the package, and the paper of its first model."""
DISK = "disk, "
"""Start of the names of the disk's systems; the name of the law follows."""
LAWS = {
    "coulomb": ("lesaux2005",),
    "coulomb-regularised": ("lesaux2005",),
    "creep-1": ("fenichel1979", "fraser1988"),
    "creep-2": ("fenichel1979", "fraser1988"),
    "creep-3": ("fenichel1979", "fraser1988"),
}
"""Works of a contact law beyond that of the model."""


def cited(
    law: str | None = None,
    *,
    model: bool = False,
    methods: Iterable[str] = (),
    eigenvalues: bool = False,
    proofs: bool = False,
    theory: Iterable[str] = (),
    system: str = "",
) -> str:
    """Keys of the works, as an attribute of a result: joined by commas, without a date.

    Parameters
    ----------
    law
        Name of the contact law; None for a user's system.
    model
        Whether the body is the thin disk, or a body of revolution: frames, signs and viscous
        friction of both are from a paper.
    methods
        Keys of the works on the integrators that ran.
    eigenvalues
        Whether LAPACK computed eigenvalues.
    proofs
        Whether verdicts or boundaries were proved exactly or in balls.
    theory
        Keys of works on what is computed, beyond those of the model.
    system
        Name of the system, in place of `law`: with `model`, or for the disk, its end says the law.

    Examples
    --------
    >>> cited("viscous", model=True, methods=["heyoka"])
    'stability, przybylska2016, casadi, heyoka'
    >>> cited(methods=["scipy", "hairer1996", "scipy", "hairer1993"])
    'stability, casadi, scipy, hairer1996, hairer1993'
    >>> cited(system="disk, coulomb") == cited(system="torus, coulomb", model=True)
    True
    >>> cited(system="disk, coulomb"), cited(system="pendulum, coulomb")
    ('stability, przybylska2016, lesaux2005, casadi', 'stability, casadi')
    """
    model = model or system.startswith(DISK)
    if model and law is None:  # the system of a body is named after it and its law
        law = system.rpartition(", ")[2]
    keys = ["stability"]
    keys += ["przybylska2016"] * model
    keys += LAWS.get(law or "", ())
    keys += theory
    keys += ["casadi"]
    keys += ["lapack"] * eigenvalues
    keys += ["arb"] * proofs
    keys += methods
    joined_keys = ", ".join(dict.fromkeys(keys))
    if (into := _INTO.get()) is not None:
        into.append(joined_keys)
    return joined_keys


def joined(every: Iterable[str]) -> str:
    """Keys of several results, each once, in the order of the first that has it.

    Examples
    --------
    >>> joined(["stability, casadi", "stability, casadi, lapack"])
    'stability, casadi, lapack'
    """
    return ", ".join(dict.fromkeys(key for keys in every for key in keys.split(", ")))


_INTO: ContextVar[list[str] | None] = ContextVar("citations", default=None)


@contextmanager
def gathered() -> Iterator[list[str]]:
    """The keys of every result that is made inside, such as those of the motions of a table.

    Examples
    --------
    >>> with gathered() as every:
    ...     _ = cited(methods=["heyoka"])
    >>> every
    ['stability, casadi, heyoka']
    """
    before, collected = _INTO.get(), list[str]()
    place = _INTO.set(collected)
    try:
        yield collected
    finally:
        _INTO.reset(place)
        if before is not None:
            before += collected


ATTRIBUTE = "citation"
"""Name of the attribute of datasets and files."""


@dataclass(frozen=True, eq=False)
class Citation(Record):
    """What to cite; it prints as text, and then as BibTeX.

    Source: the entries of stability/base/works.json, checked by tests/base/test_citation.py.

    Examples
    --------
    >>> import stability as st
    >>> works = st.citation(st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3)))
    >>> [work.key for work in works.works]
    ['stability', 'przybylska2016', 'casadi', 'lapack']
    """

    works: tuple[CitedWork, ...]
    """The works, this package first, in the version that made the result."""
    made: str = ""
    """Of a figure, film or page in a file: the call that made it, in a sentence."""

    @property
    def text(self) -> str:
        """The call, and one line for each work, with what it is cited for."""
        lines = [f"{work.role}:\n  {work.text}" for work in self.works]
        return "\n".join([self.made] * bool(self.made) + lines)

    @property
    def bibtex(self) -> str:
        """Entries of BibTeX."""
        return "\n\n".join(work.bibtex for work in self.works)

    def __str__(self) -> str:
        return f"{self.text}\n\n{self.bibtex}"


def citation(result: Any = None) -> Citation:
    """What to cite for the model, the data and the methods of a result.

    Parameters
    ----------
    result
        What a call of this package returned, or `read_map` or `read_motion` read: anything with
        `.citation` or `attrs["citation"]`, or a list of these; or the path of a figure, film, page
        or dataset that it wrote.  When left out: this package, and the paper of the disk.

    Returns
    -------
    Citation
        `works`, `text`, and `bibtex`.

    Raises
    ------
    ParameterError
        If the object says nothing of what to cite.
    FileError
        If the file says nothing of it, cannot be read, or has been changed since it was written.

    Source: the works' own pages; tests/base/test_citation.py.

    Examples
    --------
    >>> import stability as st
    >>> print(st.citation().text.splitlines()[1].strip()[:47])
    The stability developers, stability: stability
    """
    if result is None:
        return citation_of_keys(MODEL)
    if isinstance(result, (str, os.PathLike)):
        file_citation: Callable[[Any], Citation] = function_of("citation of a file")
        return file_citation(result)
    keys = keys_of(result)
    if not keys:
        raise ParameterError(
            f"{shown(type(result).__name__)} says nothing of what to cite; give a result of this "
            "package, such as a spectrum, a map, a motion or an answer."
        )
    attrs = getattr(result, "attrs", {})
    software = attrs.get("software") or attrs.get("stability_version") or __version__
    return citation_of_keys(keys, str(software).rpartition(" ")[2])


def keys_of(result: Any) -> str:
    """Keys of the works of a result, or of each in a list; empty where one says nothing."""
    keys = getattr(result, "attrs", {}).get(ATTRIBUTE) or getattr(result, ATTRIBUTE, "")
    if not keys and isinstance(result, (list, tuple)):
        every = [keys_of(entry) for entry in result]
        return joined(every) if all(every) else ""
    return keys if isinstance(keys, str) else ""


def citation_of_keys(keys: str, version: str = __version__, made: str = "") -> Citation:
    """The works with these keys, and this package in a version."""
    names = [key.strip() for key in keys.split(",")]
    for name in names:
        if name not in WORKS:
            raise ParameterError(
                f"the result cites {shown(name)}, which this version does not know; read it with "
                "the version that wrote it."
            )
    package = replace(WORKS["stability"], place=f"version {version}")
    return Citation(tuple(package if name == package.key else WORKS[name] for name in names), made)
