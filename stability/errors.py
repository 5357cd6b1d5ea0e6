"""What can go wrong, one class each; a message is one sentence with the value and the remedy."""

from __future__ import annotations


class StabilityError(ValueError):
    """Any input that the package refuses.

    Examples
    --------
    >>> import stability as st
    >>> try:
    ...     st.Disk(k=0.7)
    ... except st.StabilityError as error:
    ...     print(error)
    k is 0.7; a thin body has a diametral inertia factor in (0, 1/2].
    """


class ParameterError(StabilityError):
    """A number outside what the model accepts (sign, range, NaN, infinite, shape)."""


class NameUnknownError(StabilityError):
    """A family, axis, contact law, table or state that does not exist."""


class DomainError(StabilityError):
    """A state at which the equations of motion have no meaning (flat, or D ≤ 0)."""


class NoMemberError(StabilityError):
    """A steady motion that does not exist, or that the root-finder did not reach."""


class FileError(StabilityError):
    """A file that cannot be read or written, or that would be overwritten."""
