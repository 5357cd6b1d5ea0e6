"""Exact numbers: fields over Q, rational functions, isolated roots.

May import `base` and the modules of `algebra`.
To add a field: a class with exact arithmetic and a decidable zero, as in `number_fields.py`.
"""
