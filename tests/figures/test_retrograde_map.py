"""The map of rings that turn back can be printed, and its words follow from its numbers."""

import numpy as np
import pytest
from figure_audit import drawn, faults

import stability as st
from stability.figures.canvas import COLUMN

SOME = np.linspace(0, 1, 9)


@pytest.mark.long
def test_the_map_can_be_printed_and_says_who_turns_back() -> None:
    chart = st.retrograde_map(SOME, SOME)
    figure = st.plot_retrograde(chart)
    assert faults(figure, COLUMN) == []
    assert {"turns back", "does not"} <= {t.get_text() for t, _ in drawn(figure)}
    # the words are those of the numbers: from a faster start no ring of this grid turns back
    fast = st.retrograde_map(SOME[:3], SOME[:2], starts=[(70.0, 2.0)])
    assert "turns back" not in {t.get_text() for t, _ in drawn(st.plot_retrograde(fast))}


@pytest.mark.long
def test_other_data_are_refused() -> None:
    with pytest.raises(st.StabilityError, match="give what retrograde_map returns"):
        st.plot_retrograde(3)  # type: ignore[arg-type]
    with pytest.raises(st.StabilityError, match="give at least two"):
        st.plot_retrograde(st.retrograde_map([0.5], [0.0, 1.0]))
