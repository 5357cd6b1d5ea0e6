"""Maps of ten systems cell by cell, against steady motions and eigenvalues by SciPy and NumPy."""

import numpy as np
import pytest
from ten_systems import KNOWN, Known

import stability as st


@pytest.mark.long
@pytest.mark.parametrize("known", KNOWN, ids=lambda k: k.name)
def test_every_cell_has_the_verdict_and_growth_rate_of_its_member(known: Known) -> None:
    one, two, *_ = known.parameters
    fixed = {n: v for n, v in known.fixed.items() if n != two}
    found = st.stability_map(
        known.family, x=(one, *known.axis, 8), y=(two, *known.other, 6), **fixed
    )
    words = dict(
        zip(
            np.atleast_1d(found.verdict.attrs["flag_values"]).tolist(),
            found.verdict.attrs["flag_meanings"].split(),
            strict=True,
        )
    )
    compared = 0
    for second, row in zip(found[two].values, found.verdict.values, strict=True):
        for first, code in zip(found[one].values, row, strict=True):
            place = [first, second, *list(known.parameters.values())[2:]]
            state = known.followed(place)
            if state is None:
                assert words[int(code)] in ("no_member", "undecided"), place
                continue
            growth = np.linalg.eigvals(known.slope(state, place)).real.max()
            cell = found.abscissa.sel({one: first, two: second})
            assert float(cell) == pytest.approx(growth, abs=1e-7), place
            if abs(growth) > 1e-8:
                assert words[int(code)] == ("unstable" if growth > 0 else "stable"), place
                compared += 1
    assert compared >= 24
