"""Errors, checks, axes, verdicts, types; calls of public names; what to cite.

The ground floor.  May import nothing of the package.
To add a check of an argument: a function in `checks.py` that returns the checked value, or raises
with a sentence that shows the value and what is accepted.
To add a kind of error: a class in `errors.py`.
To add a work to cite: an entry of `WORKS` in `citation.py`, and its key in the tables after it.
To add a type of argument that calls are checked for: its test and its words in `calls.py`.
"""
