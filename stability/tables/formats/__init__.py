"""Forms of a table: text, CSV, JSON, LaTeX.

Columns with meaning and unit, and what is printed of them; no table of its own.
May import `base`, `storage`.
To add a form: a function in a module like `csv_text.py`, its ending in `FORMS` of `table.py`.
"""
