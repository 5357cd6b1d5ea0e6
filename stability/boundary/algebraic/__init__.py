"""Boundaries of families that are algebraic along the axis, though not rational: exact candidates.

`tower` writes every function of the axis and every unknown as a variable with a polynomial
relation, `candidates` the conditions in these variables and the values of the axis at which one of
them can vanish, and `exact_search` the family's own members between and at these values.
May import what `boundary` may, and its `brackets`, `interval_search` and `search`.
To add a function of the axis: an entry in `tower.Clock`.
"""
