"""Figures of outcomes of launches: the basin diagram.

May import what `figures` may.  `fates.py` gives every end of a launch its colour and hatching.
To add a figure of launches: a module like `basins.py`.
"""
