"""Errors, checks, axes, verdicts, types.

The ground floor.  May import nothing of the package.
To add a check of an argument: a function in `checks.py` that returns the checked value, or raises
with a sentence that shows the value and what is accepted.
To add a kind of error: a class in `errors.py`.
"""
