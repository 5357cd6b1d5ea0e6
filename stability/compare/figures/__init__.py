"""Figures of the comparison.

To add a figure: a module with a function from a dataset of the comparison to a `Figure`, and a
`Plate` for it in `compare/report.py`.
"""
