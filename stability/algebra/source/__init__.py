"""Formulas written as source of another language.

May import `base` and the modules of `algebra`.
To add a language: a `Language` where it is used, with its numbers, functions and powers.
"""
