"""Formulas of a family as source: JavaScript, shader, HTML; the number type that writes them.

May import `algebra`, `base`.
To add a language: a `Language` in `source_text.py`.
"""
