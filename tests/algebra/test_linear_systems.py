"""Inverses of many matrices, of which some have none."""

from __future__ import annotations

import numpy as np

from stability.algebra.linear_systems import inverse_of


def test_a_matrix_without_an_inverse_leaves_the_others_theirs() -> None:
    """LAPACK refuses a stack for one singular matrix, and an SVD for one that is not finite."""
    regular = np.array([[2.0, 1.0], [0.0, 4.0]])
    stack = np.array([regular, np.ones((2, 2)), np.full((2, 2), np.nan), [[np.inf, 0], [0, 1]]])
    found = inverse_of(stack)
    assert np.array_equal(found[0], [[0.5, -0.125], [0.0, 0.25]])
    assert np.isnan(found[1:]).all()
