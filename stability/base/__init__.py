"""Errors, checks, axes, verdicts, types.

The ground floor, with what to cite.  May import nothing of the package.
To add a check of an argument: a function in `checks.py` that returns the checked value, or raises
with a sentence that shows the value and what is accepted.
To change how a verdict is drawn: its row in `looks.py`; how results print: `printing.py`.
To add a kind of error: a class in `errors.py`.
To add a work to cite: an entry of `works.json`, and its key in a table of `citation.py`.
To add a type of argument that calls are checked for: its test and its words in `calls.py`.
"""
