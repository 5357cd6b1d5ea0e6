"""Input of other programs.

LaTeX, C, AUTO-07p and BifurcationKit.jl, from the graph that the package evaluates.
May import `basin`, `scene` and the floors below.
To add a format: one function in a module like `c_code.py`, for a program that continues equilibria
in `continuation.py`; its name on the face, and a word in `FORMATS` of `cli/export.py`.
"""
