"""Growth rates of maps by compiled loops, next to the NumPy route of `GrowthKernel`.

`factors` is the arithmetic of one cell, `loops` evaluates coefficients and runs over a tile, and
`rates` builds their tables and gives them tiles.  `squares` takes a polynomial of two terms.
May import `spectra` and the floors below.
To add a degree of a factor: its correction and its discs in `factors.py`, and both in `loops.py`.
"""
