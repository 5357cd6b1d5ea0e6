"""Proof, piece by piece along an axis, that no eigenvalue meets the imaginary axis.

May import what `boundary` may, and `boundary.brackets`.  `taylor` holds the arithmetic, `meetings` the
functions that vanish where an eigenvalue meets the axis, and `pieces` the search.
"""
