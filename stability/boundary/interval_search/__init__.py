"""Proof, piece by piece along an axis, that no eigenvalue meets the imaginary axis.

`taylor` holds the arithmetic, `meetings` the functions that vanish where an eigenvalue meets the
axis, `disc_meetings` the proofs from eigenvectors that come first, and `pieces` the search, many
pieces at once in double precision by `quick_pieces`.
May import what `boundary` may, and its `brackets`.
To add a function whose zeros count as meetings: a form in `GraphMeetings.functions`.
"""
