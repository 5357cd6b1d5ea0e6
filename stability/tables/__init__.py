"""Registered tables, recomputed.

`st.table` and the command line ask `registry.py` alone.
May import `basin`, `scene` and the floors below.
To add a table: a module with its rows and a `Definition` named `TABLE`, like `drift.py`, and its
name in `PLACES` of `registry.py`; text, CSV, JSON and LaTeX follow from the columns.
To add a table of one family: a function from the family to a `Table`, like `birth_table` of
`beyond_linear.py`, and its place in `OF_FAMILY`.
To add a form: a function like `plain` of `table.py`, and its ending in `FORMS` there.
"""
