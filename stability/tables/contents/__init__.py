"""The registry as data: which tables there are, from what source, and with what standing.

May import `formats`.  To add a table: its name in `PLACES` of `places.py`, and an `About` in its
`Definition`; the list and the command read both.
"""
