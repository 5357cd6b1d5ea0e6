"""Forms of a table: text, CSV, JSON, LaTeX.

Columns with meaning and unit, and what is printed of them; no table of its own.
May import `base`, `storage`, and the disk's quantities of `bodies`.
To add a form: a function in a module like `plain.py`, its ending in `FORMS` of `table.py`.
"""
