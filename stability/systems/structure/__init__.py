"""What holds for the spectrum of a family by structure, with the proof at each member.

`structural_zeros` counts the zero eigenvalues of a whole family, `multiplicity` proves the count
at one member, `enclosure` has members in ball arithmetic.
To add a structure (a symmetry, an integral): write one module with a function of a `Family`.
"""
