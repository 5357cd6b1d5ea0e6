"""What holds for the spectrum of a family by structure, with the proof at each member.

`structural_zeros` counts the zero eigenvalues of a whole family, `identities` proves the count and
the symmetry λ → -λ for every member, `member` proves both at one member in exact numbers, and
`zero_blocks` how zeros grow.  `enclosure` has members in ball arithmetic.
To add a structure (a symmetry, an integral): write one module with a function of a `Family`.
"""
