"""Routes to eigenvalues, compared.

May import what `compare` may.  To add a route: a subclass of `Route` in `routes.py`, its class in
`PEOPLE` there.
To add a hard case: a subclass of `Case` in `cases.py`, and its class in `_EVERY` there.
"""
