"""Fractions and exponents of labels, with their intervals.

Each module takes labels, or a function that gives them, and returns a record with what it assumes.
May import `base` and the rest of `basin`.
To add a measure: a module with one function and one frozen record, with its source.
"""
