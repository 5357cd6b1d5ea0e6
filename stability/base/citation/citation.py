"""`citation`: what to cite for a result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..errors import ParameterError, shown
from ..types import Record
from .used import MODEL, joined
from .works import WORKS, Work

ATTRIBUTE = "citation"
"""Name of the attribute of datasets and files."""


@dataclass(frozen=True, eq=False)
class Citation(Record):
    """What to cite; it prints as text, and then as BibTeX.

    Source: the entries of stability/base/citation/works.py, checked by tests/base/test_citation.py.

    Examples
    --------
    >>> import stability as st
    >>> found = st.citation(st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3)))
    >>> [work.key for work in found.works]
    ['stability', 'przybylska2016', 'casadi', 'lapack']
    """

    works: tuple[Work, ...]
    """The works, this package first."""

    @property
    def text(self) -> str:
        """One line for each work, with what it is cited for."""
        return "\n".join(f"{work.role}:\n  {work.text}" for work in self.works)

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
        `.citation` or `attrs["citation"]`, or a list of these.  When left out: this package, and
        the paper of the disk.

    Returns
    -------
    Citation
        `works`, `text`, and `bibtex`.

    Raises
    ------
    ParameterError
        If the object says nothing of what to cite.

    Source: the works' own pages; tests/base/test_citation.py.

    Examples
    --------
    >>> import stability as st
    >>> print(st.citation().text.splitlines()[1].strip()[:47])
    The stability developers, stability: stability
    """
    if result is None:
        return of_keys(MODEL)
    keys = _keys(result)
    if not keys:
        raise ParameterError(
            f"{shown(type(result).__name__)} says nothing of what to cite; give a result of this "
            "package, such as a spectrum, a map, a motion or an answer."
        )
    return of_keys(keys)


def _keys(result: Any) -> str:
    """Keys of a result, or of each in a list; empty where one says nothing."""
    keys = getattr(result, "attrs", {}).get(ATTRIBUTE) or getattr(result, ATTRIBUTE, "")
    if not keys and isinstance(result, (list, tuple)):
        every = [_keys(one) for one in result]
        return joined(every) if all(every) else ""
    return keys if isinstance(keys, str) else ""


def of_keys(keys: str) -> Citation:
    """The works with these keys.

    Parameters
    ----------
    keys
        Keys, joined by commas.

    Raises
    ------
    ParameterError
        If a key is unknown, as in a file of a later version.
    """
    names = [key.strip() for key in keys.split(",")]
    for name in names:
        if name not in WORKS:
            raise ParameterError(
                f"the result cites {shown(name)}, which this version does not know; read it with "
                "the version that wrote it."
            )
    return Citation(tuple(WORKS[name] for name in names))
