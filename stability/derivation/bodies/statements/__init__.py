"""Rows of `stability table bodies`: what each statement about bodies of revolution says.

`entry` is the record; `polynomials`, `known_results`, `rounded_rim` and `limits` make rows.  May
import `derivation/bodies`.  To add rows: a function that returns entries, called in `catalogue`.
"""
