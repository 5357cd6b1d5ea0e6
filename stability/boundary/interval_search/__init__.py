"""Proof, piece by piece along an axis, that no eigenvalue meets the imaginary axis.

`taylor` and `blocks` hold the arithmetic, `meetings` the functions that vanish where an eigenvalue
meets the axis, `pieces` the search, and `proved` its result.
May import what `boundary` may, and its `brackets`, `crossings` and `scan`.
To add a function whose zeros count as meetings: a form in `Meetings.functions`.
"""
