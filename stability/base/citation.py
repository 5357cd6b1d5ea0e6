"""What to cite: works, their keys by what a call has used, and `citation`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any

from .errors import ParameterError, shown
from .types import Record
from .version import __version__


@dataclass(frozen=True)
class Work:
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
    doi: str = ""
    """DOI."""

    @property
    def text(self) -> str:
        """The work in one line."""
        people = [_forward(name) for name in self.author.strip("{}").split(" and ")]
        many = ", ".join(people[:-1]) + " and " + people[-1] if len(people) > 1 else people[0]
        where = " ".join(filter(None, [self.place, self.volume]))
        parts = [many, self.title, where, self.pages.replace("--", "-"), self.year]
        return ", ".join(filter(None, parts)) + (f", doi:{self.doi}" if self.doi else "")

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


_EVERY = (
    Work(
        "stability",
        "software",
        "this package",
        "{The stability developers}",
        "stability: stability diagrams of nonholonomic and frictional systems, with proved "
        "boundaries",
        "",
        f"version {__version__}",
    ),
    Work(
        "przybylska2016",
        "article",
        "the model of the disk, and the frames of bodies of revolution",
        "Przybylska, Maria and Rauch-Wojciechowski, Stefan",
        "Dynamics of a Rolling and Sliding Disk in a Plane. Asymptotic Solutions, Stability and "
        "Numerical Simulations",
        "2016",
        "Regular and Chaotic Dynamics",
        "21(2)",
        "204--231",
        "10.1134/S1560354716020052",
    ),
    Work(
        "lesaux2005",
        "article",
        "dry friction of the disk",
        "Le Saux, Caroline and Leine, Remco I. and Glocker, Christoph",
        "Dynamics of a Rolling Disk in the Presence of Dry Friction",
        "2005",
        "Journal of Nonlinear Science",
        "15",
        "27--61",
        "10.1007/s00332-004-0655-4",
    ),
    Work(
        "as2017",
        "misc",
        "a circling disk of 0.5 m, whose spin is printed",
        "As, Y.",
        "Student report on a rolling disk",
        "2017",
        "Technion",
    ),
    Work(
        "fenichel1979",
        "article",
        "slow manifolds: creeping slip, and drift along a family",
        "Fenichel, Neil",
        "Geometric singular perturbation theory for ordinary differential equations",
        "1979",
        "Journal of Differential Equations",
        "31",
        "53--98",
        "10.1016/0022-0396(79)90152-9",
    ),
    Work(
        "fraser1988",
        "article",
        "the iteration of the slow manifold",
        "Fraser, Simon J.",
        "The steady state and equilibrium approximations: A geometrical picture",
        "1988",
        "The Journal of Chemical Physics",
        "88",
        "4732--4738",
        "10.1063/1.454686",
    ),
    Work(
        "fiedler2000",
        "article",
        "Hopf bifurcation of a line of steady motions",
        "Fiedler, Bernold and Liebscher, Stefan and Alexander, James C.",
        "Generic Hopf bifurcation from lines of equilibria without parameters: I. Theory",
        "2000",
        "Journal of Differential Equations",
        "167",
        "16--35",
    ),
    Work(
        "kuznetsov2004",
        "book",
        "Lyapunov coefficients, and points of codimension two",
        "Kuznetsov, Yuri A.",
        "Elements of Applied Bifurcation Theory, third edition",
        "2004",
        "Springer",
        "",
        "",
        "10.1007/978-1-4757-3978-7",
    ),
    Work(
        "casadi",
        "article",
        "the graph of the equations and its derivatives (CasADi)",
        "Andersson, Joel A. E. and Gillis, Joris and Horn, Greg and Rawlings, James B. and Diehl, "
        "Moritz",
        "CasADi: a software framework for nonlinear optimization and optimal control",
        "2019",
        "Mathematical Programming Computation",
        "11(1)",
        "1--36",
        "10.1007/s12532-018-0139-4",
    ),
    Work(
        "lapack",
        "book",
        "eigenvalues (LAPACK)",
        "Anderson, Edward and Bai, Zhaojun and Bischof, Christian and Blackford, Susan and "
        "Demmel, James and Dongarra, Jack and Du Croz, Jeremy and Greenbaum, Anne and Hammarling, "
        "Sven and McKenney, Alan and Sorensen, Danny",
        "LAPACK Users' Guide, third edition",
        "1999",
        "Society for Industrial and Applied Mathematics",
    ),
    Work(
        "arb",
        "article",
        "proofs in ball arithmetic (Arb, by python-flint)",
        "Johansson, Fredrik",
        "Arb: efficient arbitrary-precision midpoint-radius interval arithmetic",
        "2017",
        "IEEE Transactions on Computers",
        "66(8)",
        "1281--1292",
        "10.1109/TC.2017.2690633",
    ),
    Work(
        "sympy",
        "article",
        "algebra of proofs and formulas (SymPy)",
        "Meurer, Aaron and Smith, Christopher P. and Paprocki, Mateusz and others",
        "SymPy: symbolic computing in Python",
        "2017",
        "PeerJ Computer Science",
        "3",
        "e103",
        "10.7717/peerj-cs.103",
    ),
    Work(
        "heyoka",
        "article",
        "integration by Taylor's method (heyoka)",
        "Biscani, Francesco and Izzo, Dario",
        "Revisiting high-order Taylor methods for astrodynamics and celestial mechanics",
        "2021",
        "Monthly Notices of the Royal Astronomical Society",
        "504(2)",
        "2614--2628",
        "10.1093/mnras/stab1032",
    ),
    Work(
        "scipy",
        "article",
        "integration (SciPy)",
        "Virtanen, Pauli and Gommers, Ralf and Oliphant, Travis E. and others",
        "SciPy 1.0: fundamental algorithms for scientific computing in Python",
        "2020",
        "Nature Methods",
        "17(3)",
        "261--272",
        "10.1038/s41592-019-0686-2",
    ),
    Work(
        "hairer1993",
        "book",
        "the method DOP853",
        "Hairer, Ernst and Nørsett, Syvert P. and Wanner, Gerhard",
        "Solving Ordinary Differential Equations I: Nonstiff Problems",
        "1993",
        "Springer",
        "",
        "",
        "10.1007/978-3-540-78862-1",
    ),
    Work(
        "hairer1996",
        "book",
        "the method Radau IIA",
        "Hairer, Ernst and Wanner, Gerhard",
        "Solving Ordinary Differential Equations II: Stiff and Differential-Algebraic Problems",
        "1996",
        "Springer",
        "",
        "",
        "10.1007/978-3-642-05221-7",
    ),
    Work(
        "petzold1983",
        "article",
        "the method LSODA",
        "Petzold, Linda",
        "Automatic selection of methods for solving stiff and nonstiff systems of ordinary "
        "differential equations",
        "1983",
        "SIAM Journal on Scientific and Statistical Computing",
        "4(1)",
        "136--148",
        "10.1137/0904010",
    ),
    Work(
        "shampine1997",
        "article",
        "the BDF method",
        "Shampine, Lawrence F. and Reichelt, Mark W.",
        "The MATLAB ODE Suite",
        "1997",
        "SIAM Journal on Scientific Computing",
        "18(1)",
        "1--22",
        "10.1137/S1064827594276424",
    ),
    Work(
        "sundials",
        "article",
        "integration of stiff motions (SUNDIALS, by CasADi)",
        "Hindmarsh, Alan C. and Brown, Peter N. and Grant, Keith E. and Lee, Steven L. and "
        "Serban, Radu and Shumaker, Dan E. and Woodward, Carol S.",
        "SUNDIALS: Suite of nonlinear and differential/algebraic equation solvers",
        "2005",
        "ACM Transactions on Mathematical Software",
        "31(3)",
        "363--396",
        "10.1145/1089014.1089020",
    ),
    Work(
        "grebogi1983",
        "article",
        "the uncertainty exponent",
        "Grebogi, Celso and McDonald, Steven W. and Ott, Edward and Yorke, James A.",
        "Final state sensitivity: an obstruction to predictability",
        "1983",
        "Physics Letters A",
        "99(9)",
        "415--418",
        "10.1016/0375-9601(83)90945-3",
    ),
    Work(
        "wilson1927",
        "article",
        "intervals of a probability",
        "Wilson, Edwin B.",
        "Probable Inference, the Law of Succession, and Statistical Inference",
        "1927",
        "Journal of the American Statistical Association",
        "22(158)",
        "209--212",
        "10.1080/01621459.1927.10502953",
    ),
)
WORKS = {work.key: work for work in _EVERY}
"""Every work by its key."""


MODEL = "stability, przybylska2016"
"""What is cited without a computation: the package, and the paper of its first model."""
METHODS = {
    "heyoka": ("heyoka",),
    "dop853": ("scipy", "hairer1993"),
    "lsoda": ("scipy", "petzold1983"),
    "radau": ("scipy", "hairer1996"),
    "bdf": ("scipy", "shampine1997"),
    "cvodes": ("sundials",),
    "idas": ("sundials",),
}
"""Works of each integrator."""
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
        Names of the integrators that ran.
    eigenvalues
        Whether LAPACK computed eigenvalues.
    proofs
        Whether verdicts or boundaries were proved exactly or in balls.
    theory
        Keys of works on what is computed, beyond those of the model.
    system
        Name of the system, in place of `law` and `model`: that of the disk's systems says both.

    Returns
    -------
    str

    Examples
    --------
    >>> cited("viscous", model=True, methods=["heyoka"])
    'stability, przybylska2016, casadi, heyoka'
    >>> cited(methods=["radau", "dop853"])
    'stability, casadi, scipy, hairer1996, hairer1993'
    >>> cited(system="disk, coulomb"), cited(system="pendulum")
    ('stability, przybylska2016, lesaux2005, casadi', 'stability, casadi')
    """
    if system.startswith(DISK):
        law, model = system.removeprefix(DISK), True
    keys = ["stability"]
    keys += ["przybylska2016"] * model
    keys += LAWS.get(law or "", ())
    keys += theory
    keys += ["casadi"]
    keys += ["lapack"] * eigenvalues
    keys += ["arb"] * proofs
    for method in methods:
        keys += METHODS.get(method, ())
    found = ", ".join(dict.fromkeys(keys))
    if (into := _INTO.get()) is not None:
        into.append(found)
    return found


def joined(every: Iterable[str]) -> str:
    """Keys of several results, each once, in the order of the first that has it.

    Parameters
    ----------
    every
        Keys of each result.

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
    before, found = _INTO.get(), list[str]()
    place = _INTO.set(found)
    try:
        yield found
    finally:
        _INTO.reset(place)
        if before is not None:
            before += found


ATTRIBUTE = "citation"
"""Name of the attribute of datasets and files."""


@dataclass(frozen=True, eq=False)
class Citation(Record):
    """What to cite; it prints as text, and then as BibTeX.

    Source: the entries of stability/base/citation.py, checked by tests/base/test_citation.py.

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
