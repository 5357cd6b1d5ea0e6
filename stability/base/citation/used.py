"""Keys of works by what was used: contact law, body, integrators, proofs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

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
