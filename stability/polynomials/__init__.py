"""det(λ - A) over Q.

`CharacteristicPolynomial` reads the graph of any family once, with any of its numbers as variables:
none (a member), one (an axis), two (a plane), or all of them (conditions, formulas, identities).
`identities` proves the zeros and the symmetry λ → -λ of a family for every member, `member` proves
both at one member in exact numbers, and `zero_blocks` how zeros grow.
May import `systems`, `jobs` and the floors below.
To add a function that graphs may hold: an indeterminate in `algebra/exact/function_field.py`.
"""
