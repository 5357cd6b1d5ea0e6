"""What holds for the spectrum of a family by structure.

`structural_zeros` counts the zero eigenvalues of a whole family at samples, `places` proves what
the zero entries show, `linearity` which rates are linear.  `enclosure` has members in balls.
To add a structure (a symmetry, an integral): write one module with a function of a `Family`.
"""
