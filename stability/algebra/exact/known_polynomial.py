"""Characteristic polynomials that are known exactly, of a body or of a user's family.

Verdicts are then proved from the known coefficients instead of the graph's.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from ...base.citation import cited
from ...base.errors import ParameterError, shown
from ...base.types import content
from ...base.user_code import arithmetic
from ..number_types import Algebra
from ..polynomial import Polynomial


@dataclass(frozen=True)
class Exact:
    """Polynomial and conditions of a family under a law, over Q.

    Source: docs/explanation/method.md; tests/spectra/test_exact_polynomial.py.

    Examples
    --------
    >>> import stability as st
    >>> found = st.exact_polynomial("spinning", "viscous")
    >>> found.variables, found.zeros
    (('k', 'M', 'z'), 1)
    """

    family: str
    """Name of the family."""
    law: str
    """Name of the contact law."""
    variables: tuple[str, ...]
    """For the disk: k, then M = mu*² (laws with mu), then z = at*² or s = sinθ (both for circling
    and precession, z = φ̇*²)."""
    zeros: int
    """Number of structural zeros."""
    even: bool
    """Whether the polynomial without its structural zeros is even in λ."""
    factors: tuple[tuple[Polynomial, ...], ...]
    """Factors over Q; each by powers of σ, lowest first.  λ = σ mu*, or λ = σ without mu."""
    conditions: tuple[tuple[str, Polynomial], ...]
    """(kind, polynomial): all positive means stable (or neutral), some negative means unstable."""

    @property
    def citation(self) -> str:
        """Keys of the works to cite, for `stability.citation`."""
        return cited(self.law, model=True, proofs=True)

    @arithmetic("give numbers of one type")
    def coefficients(self, values: Sequence[Any]) -> list[list[Any]]:
        """Coefficients of each factor at a point, lowest power of σ first.

        Parameters
        ----------
        values
            Values of `variables`, of any number type.

        Returns
        -------
        list of list
        """
        if isinstance(values, (str, bytes)) or len(values) != len(self.variables):
            raise ParameterError(
                f"values is {shown(values)}; give one number for each of "
                f"{', '.join(self.variables)}."
            )
        return [[c(*values) for c in factor] for factor in self.factors]


class ExactPolynomial:
    """The characteristic polynomial of a family, from the numbers that name a member.

    A subclass for your family has one method, `coefficients`, and `zeros` where eigenvalues vanish
    by structure.  `Family` takes an instance as `exact`, if no unknown is solved for.  At first
    use the package compares the polynomial with the equations of motion at random members.

    Source: docs/explanation/method.md; tests/spectra/test_exact_polynomial.py.

    Examples
    --------
    >>> import stability as st
    >>> import casadi as ca, stability as st
    >>> class Damped(st.ExactPolynomial):
    ...     def coefficients(self, values, algebra):  # λ² + d λ + g
    ...         return [[values["g"], values["d"], 1]]
    >>> x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    >>> system = st.System("pendulum", x, p, ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - p[1] * x[1]),
    ...                    states=("angle", "rate"), parameters=("g", "d"))
    >>> hanging = st.Family(system, "hanging", at=("g",), held={"angle": 0, "rate": 0},
    ...                     exact=Damped())
    >>> st.spectrum(hanging, at=1.0, d=0.0).reason
    ... # doctest: +ELLIPSIS
    "double precision left it open; proved in rational arithmetic from the family's polynomial; ..."
    """

    zeros: int = 0
    """Number of eigenvalues that vanish by structure; the coefficients leave them out."""
    derived: ClassVar[bool] = False
    """Whether polynomial and conditions are proved for every member and a member's unknowns are
    unique.  The comparison at first use is then left out."""

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and content(vars(self)) == content(vars(other))

    def __hash__(self) -> int:
        return hash((type(self), content(vars(self))))

    def __init__(self) -> None:
        """Nothing to keep; a subclass may have numbers of its own."""

    def coefficients(
        self,
        values: Mapping[str, Any],  # noqa: ARG002
        algebra: Algebra,  # noqa: ARG002
    ) -> Sequence[Sequence[Any]]:
        """Coefficients of the factors of the polynomial in λ, lowest power first.

        Parameters
        ----------
        values
            Numbers of one type by name, in the user's units: rational, ball, ratio in an axis.
        algebra
            Functions of this number type: `algebra.functions["sqrt"](x)`.

        Returns
        -------
        sequence of sequence
            For each factor its coefficients, real, the last one not zero.
        """
        raise ParameterError(f"the polynomial {type(self).__name__} states no coefficients.")

    def conditions(
        self,
        values: Mapping[str, Any],  # noqa: ARG002
        algebra: Algebra,  # noqa: ARG002
    ) -> list[tuple[str, Any]] | None:
        """Numbers whose signs give the verdict; only for a polynomial that is `derived`.

        Parameters
        ----------
        values, algebra
            As for `coefficients`.

        Returns
        -------
        list or None
            (kind, number): all positive means stable (or neutral), some negative means unstable.
            Kinds are static, flutter and auxiliary.  None: the verdict comes from the coefficients.
        """
        return None

    def scale(self, values: Mapping[str, Any]) -> tuple[Any, Any]:  # noqa: ARG002
        """Unit of the polynomial's variable in the user's unit of rate.

        Parameters
        ----------
        values
            Numbers by name, as for `coefficients`.

        Returns
        -------
        scale, square
            λ = σ · scale with a positive scale; where it is None, λ² = σ² · square.
        """
        return 1, None


class TabulatedPolynomial(ExactPolynomial, ABC):
    """An exact polynomial stored as `Polynomial`s in a few positive variables, proved offline.

    Maps bound these polynomials over whole arrays and boxes.  Each factor has odd degree, or the
    polynomial is even and has one factor, linear in λ².

    Parameters
    ----------
    known
        Polynomials and conditions over Q.
    """

    derived = True
    borders: bool = False
    """Whether the verdict can change where the sine of the angle is 1."""

    def __init__(self, known: Exact) -> None:
        self.known, self.zeros = known, known.zeros

    @abstractmethod
    def point(self, values: Mapping[str, Any], algebra: Algebra) -> list[Any]:
        """Values of `known.variables`.

        Parameters
        ----------
        values, algebra
            As for `coefficients`.
        """

    @abstractmethod
    def sine(self, values: Mapping[str, Any], algebra: Algebra) -> Any:
        """The sine on which the polynomials depend.

        Parameters
        ----------
        values, algebra
            As for `coefficients`.
        """

    @abstractmethod
    def roundings(self, *, dimensionless: bool) -> Mapping[str, int]:
        """Largest number of roundings in the value of each variable, in floating point, by name.

        Parameters
        ----------
        dimensionless
            Whether the user's numbers are dimensionless.
        """

    @abstractmethod
    def natural(self, point: Sequence[Any]) -> Any:
        """Square of the unit of σ in the family's own unit of rate.

        Parameters
        ----------
        point
            Values from `point`.
        """

    @abstractmethod
    def angle(self, axis: str) -> str:
        """Angle through whose sine the polynomials depend on an axis: theta, lean or empty.

        Parameters
        ----------
        axis
            Name of the axis.
        """

    @abstractmethod
    def edge(self, values: Mapping[str, Any]) -> bool:
        """Whether a member lies on the edge of the domain on which the conditions are proved.

        Parameters
        ----------
        values
            Exact numbers by name.
        """

    def coefficients(self, values: Mapping[str, Any], algebra: Algebra) -> list[list[Any]]:
        """Coefficients of the factors, as for every exact polynomial."""
        return self.known.coefficients(self.point(values, algebra))

    def conditions(self, values: Mapping[str, Any], algebra: Algebra) -> list[tuple[str, Any]]:
        """Conditions, as for every exact polynomial; on the edge one number is zero."""
        point = self.point(values, algebra)
        edge = [("static", 0)] if self.edge(values) else []
        return [(kind, p(*point)) for kind, p in self.known.conditions] + edge
