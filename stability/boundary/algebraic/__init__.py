"""Every change of verdict along an axis, by exact candidates.

`exact_search` judges each candidate.  `one_variable` has the members whose verdict is a matter of
polynomials in the axis or its sine, stored or derived; `members` those with functions of the axis
or unknowns, for which `tower` writes each as a variable with a polynomial relation.  `candidates`
isolates the values of the axis at which a watched polynomial can vanish.
May import what `boundary` may, and its `brackets`, `pairs` and `interval_search`.
To add a function of the axis: an entry in `tower.Base`.
"""
