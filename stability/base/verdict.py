"""Verdicts of a spectrum, and of the nonlinear motion as far as it is known."""

from __future__ import annotations

from .types import Sentences


class Verdict(Sentences):
    """The spectral verdict, on the eigenvalues that are not zero by structure.

    The value of each member is the sentence a user reads.

    Source: docs/explanation/method.md; exact arithmetic on random points: tests/spectra.

    Examples
    --------
    >>> import stability as st
    >>> st.Verdict.STABLE == "stable", st.Verdict("stable") is st.Verdict.STABLE, st.Verdict(1).word
    (True, True, 'stable')
    >>> print(st.Verdict.STABLE)
    stable
    """

    UNDECIDED = (
        "undecided: the abscissa is within its error bound of zero; ask nearby, or compute the "
        "boundary itself"
    )
    STABLE = "stable: every eigenvalue that is not zero by structure has a negative real part"
    UNSTABLE = "unstable: some eigenvalue has a positive real part"
    NEUTRAL = "neutral: no eigenvalue has a positive real part and some lie on the imaginary axis"
    DRIFTING = (
        "drifting: every eigenvalue that is not zero by structure has a negative real part, but "
        "zeros form a Jordan block: a disturbance grows like a power of time"
    )

    @property
    def code(self) -> int:
        """The flag value in files."""
        return CODES[self]


def best(*, even: bool) -> Verdict:
    """The verdict of a spectrum without growth: neutral or stable.

    Parameters
    ----------
    even
        Whether the polynomial is even in λ; then no mode decays either.

    Examples
    --------
    >>> best(even=True).word
    'neutral'
    """
    return Verdict.NEUTRAL if even else Verdict.STABLE


class Evidence(Sentences):
    """What a boundary rests on; the value of each member is the sentence a user reads.

    Source: docs/explanation/method.md; tests/boundary/test_by_floats.py.

    Examples
    --------
    >>> import stability as st
    >>> st.results.Evidence.BY_FLOATS.word
    'by floats, not proved'
    """

    PROVED = "proved: verdicts at both ends differ in rational arithmetic or in balls"
    BY_FLOATS = (
        "by floats, not proved: abscissas at both ends differ in sign by more than an estimated "
        "error of finite differences"
    )


NO_MEMBER = 4
"""Flag value of a cell of a map without a member; it is no verdict."""
CODES = {
    Verdict.UNDECIDED: 0,
    Verdict.STABLE: 1,
    Verdict.UNSTABLE: 2,
    Verdict.NEUTRAL: 3,
    Verdict.DRIFTING: 5,
}
"""Flag value of each verdict, in arrays and files."""
BY_CODE = {code: verdict for verdict, code in CODES.items()}
"""Verdict of each flag value."""


DECAYING = frozenset({Verdict.STABLE, Verdict.DRIFTING})
"""Verdicts of members whose eigenvalues all have negative real parts, but those by structure."""


class Nonlinear(Sentences):
    """Behaviour of the nonlinear motion; the value of each member is the sentence a user reads.

    Source: Lyapunov's and Malkin's theorems, docs/explanation/method.md: tests/spectra.

    Examples
    --------
    >>> import stability as st
    >>> st.results.Nonlinear.ASYMPTOTIC.value.split(":")[0]
    'asymptotic'
    """

    ASYMPTOTIC = (
        "asymptotic: a disturbed motion tends to this member or, where members form a line, to one "
        "next to it (Lyapunov-Malkin: every structural zero is a tangent of the family)"
    )
    DRIFTS = (
        "drifts: spectrally stable, yet not Lyapunov-stable: a disturbance that leaves a slow "
        "tilt, however small, lets the spin fall until it passes the linear threshold; until then "
        "the motion stays as near to rolling as that tilt (stability.drift, `stability table "
        "drift`)"
    )
    CARRIED = (
        "carried along: spectrally stable, yet a slow flow on the centre manifold carries a "
        "disturbed motion along the family to its threshold"
    )
    BY_INTEGRALS = "stable by integrals: first integrals keep a disturbed motion near the family"
    UNSTABLE = "unstable: some disturbance grows exponentially"
    GROWS = (
        "grows like a power of t in the linear flow: more eigenvalues vanish by structure than "
        "there are null vectors (proved: rank A > n - structural zeros); only higher orders could "
        "hold the motion"
    )
    LINEAR = (
        "linear: the rates of the states that act on others are proved to be linear in them, so "
        "that the linear flow is the whole motion and no higher orders exist; on the imaginary "
        "axis it is bounded if every eigenvalue has as many modes as its multiplicity, and grows "
        "like a power of t otherwise"
    )
    OPEN = "open: the spectrum does not decide; higher orders do"
