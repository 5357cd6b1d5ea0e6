"""Maps of any family; kernels next door serve the stored polynomials of the disk.

`slices` reads the family's polynomial over Q in the axes, `slice_verdicts` decides cells and boxes,
`rates` finds growth rates from coefficients, and `cells` computes the cells of a map by these, by
formulas, or by a graph that is not algebraic.
May import `spectra`, `derivation` and the floors below.
To add a kind of family: a reader in `slices.py` that gives a `Slice`, or raises `NotExact`.
"""
