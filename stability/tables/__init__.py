"""Registered tables, recomputed.

Rows as records, and their text.  May import `maps`, `motion` and the floors below.
To add a table: a module with a frozen dataclass of a row and a function that returns rows, its name
in `TABLES` and `records` of `registry.py`, and its text in `text` of `render.py`.
"""
