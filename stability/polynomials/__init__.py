"""det(λ - A) over Q.

`CharacteristicPolynomial` reads the graph of any family once, with any of its numbers as variables:
none, one (an axis), two (a plane), or all of them (conditions and formulas).
May import `systems`, `jobs` and the floors below.
To add a function that graphs may hold: an indeterminate in `algebra/exact/function_field.py`.
"""
