"""Flutter boundaries of ten systems and their first Lyapunov coefficients (Kuznetsov)."""

import mpmath as mp
import pytest
from ten_systems import DIGITS, KNOWN, Known

import stability as st


@pytest.mark.few(1)
@pytest.mark.parametrize("known", KNOWN, ids=lambda k: k.name)
def test_the_first_lyapunov_coefficient_lies_within_its_bound(known: Known) -> None:
    name = next(iter(known.parameters))
    found = st.hopf(known.family, axis=(name, *known.axis, 9), **known.fixed)
    assert found
    for point in found:
        at, frequency, first = known.crossing(point.at)
        with mp.workdps(DIGITS):
            own = mp.mpf(10) ** -18  # what mpmath's root and null vectors may miss, and more
            assert abs(mp.mpf(point.at) - at) <= point.error + own
            assert abs(mp.mpf(point.frequency) - frequency) <= point.frequency_error + own
            assert abs(mp.mpf(point.coefficient) - first) <= point.coefficient_error + own
        assert point.coefficient_error <= 1e-6 * abs(point.coefficient)
        assert point.kind.word == ("soft" if first < 0 else "hard")
