"""Records of exact conditions: variables, factors, signs, witnesses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from ...algebra.polynomial import Polynomial


@dataclass(frozen=True)
class Variable:
    """A variable of the polynomials."""

    name: str
    """Name as it occurs in a polynomial: `v`, `sin(theta)`, `sqrt(b)`."""
    kind: str
    """Kind: parameter, state, unknown, sine, cosine, root or function."""
    meaning: str
    """What it is, in words."""


@dataclass(frozen=True)
class Factor:
    """A factor of the characteristic polynomial, irreducible over Q."""

    coefficients: tuple[Polynomial, ...]
    """Coefficients by powers of λ, lowest first."""
    even: bool
    """Whether only even powers of λ occur: its roots come in pairs ±λ."""
    multiplicity: int
    """How often it occurs."""

    @property
    def degree(self) -> int:
        """Degree in λ."""
        return len(self.coefficients) - 1


@dataclass(frozen=True)
class Witness:
    """A member at which the sign of a condition is proved."""

    point: Mapping[str, Fraction]
    """Family parameters and parameters, exactly."""
    sign: int
    """1 or -1."""


@dataclass(frozen=True)
class SignCondition:
    """A polynomial that is positive wherever a factor has all its roots in the left half-plane."""

    name: str
    """What it is, such as `constant term` or `Hurwitz determinant 3`."""
    factor: int
    """Index of the factor of the characteristic polynomial."""
    kind: str
    """What happens where it vanishes: static (an eigenvalue is 0), flutter (a pair on the
    imaginary axis, or two pairs that meet there), or auxiliary."""
    status: str
    """positive or negative (proved in the whole domain), follows (from another condition),
    changes (both signs occur at members), open (neither is proved), or zero (identically)."""
    polynomial: Polynomial
    """The polynomial, without factors of proved sign."""
    whole: Polynomial
    """The polynomial with all its factors."""
    proof: str
    """Proof of the status, or of the signs of the factors that are left out."""
    witnesses: tuple[Witness, ...] = ()
    """Members with proved signs; one of each sign where the status is `changes`."""

    @property
    def decides(self) -> bool:
        """Whether the verdict depends on its sign."""
        return self.status in ("changes", "open", "zero", "negative")

    @property
    def doubt(self) -> str:
        """A sentence on a sign that is open: what would have to be proved."""
        where = "anywhere" if any(w.sign < 0 for w in self.witnesses) else "everywhere"
        return f"It is open whether {self.polynomial} > 0 {where}."
