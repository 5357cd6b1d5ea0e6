"""What holds for the spectrum of a family by structure, with the proof at each member.

`structural_zeros` counts the zero eigenvalues of a whole family, `identities` proves the count and
the symmetry λ → -λ for every member, `multiplicity` proves both at one member.  `pattern` is what
sparsity proves, `entries` has a symbol for each entry, `enclosure` has members in ball arithmetic.
To add a structure (a symmetry, an integral): write one module with a function of a `Family`.
"""
