"""Figures of spectra: eigenvalues along a quantity, and one spectrum in the plane.

May import what `figures` may.  `modes.py` says which eigenvalues belong to one mode, and its name.
To add a figure of a spectrum: a module like `plane.py`.
"""
