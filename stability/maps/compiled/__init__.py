"""Growth rates of large maps by compiled loops, an optional back end of `maps/engine.py`.

`factors` is the arithmetic of one cell, `loops` evaluates coefficients and runs over a grid, and
`rates` gives them the surfaces of a slice.  `squares` takes formulas of two terms.
May import `spectra` and the floors below.
To add a degree of a factor: its correction and its discs in `factors.py`, and both in `loops.py`.
"""
