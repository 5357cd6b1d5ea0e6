"""Boundaries of families that are algebraic along the axis, though not rational: exact candidates.

`tower` writes every function of the axis and every unknown as a variable with a polynomial
relation, `polynomials` the conditions in these variables, `candidates` the values of the axis at
which one of them can vanish, `branch` the family's own members between and at these values, and
`exact_search` the result.
May import what `boundary` may, and its `brackets`, `crossings`, `interval_search` and
`single_points`.
To add a function of the axis: an entry in `tower.Clock`.
"""
