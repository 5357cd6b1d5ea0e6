"""Calls of public names: the guard that names an argument that does not fit, and that of scripts.

May import the errors of `base`.
To add a type of argument: its test in `fits` and its words in `words`, in `types.py`.
"""
