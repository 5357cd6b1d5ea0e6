"""Eigenvalues and verdicts.

`spectrum` gives eigenvalues with error discs, a verdict and its proof, for numbers with units.
May import `bodies` and the floors below; `deflation` and `eigenvalues` know no body.
To add an eigensolver: nothing is written here; see `stability.algebra.eigensolver`.
"""
