"""The characteristic polynomial of any family over Q, with any of its numbers as variables.

`CharacteristicPolynomial` reads the graph once, with no number free, one (an axis), two (a plane),
or all of them (conditions and formulas).
May import `systems` and the floors below.
To read a new function of a graph: an indeterminate of `algebra/exact/function_field.py`.
"""
