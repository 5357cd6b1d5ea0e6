"""Eigenvalues and verdicts.

From a family and numbers with units to eigenvalues with error discs, a verdict, and its proof.
May import `bodies` and the floors below; `deflation`, `eigenvalues` and `modes` know no body.
To add an eigensolver: nothing is written here; see `stability.algebra.eigensolver`.
"""
