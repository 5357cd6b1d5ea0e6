"""Figures of spectra: eigenvalues along a quantity, and one spectrum in the plane.

May import what `figures` may.  `modes.py` says which eigenvalues belong to one mode, and its name.
"""
