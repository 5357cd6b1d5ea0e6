"""Routes to eigenvalues, compared.

May import what `compare` may.  To add a route: see `routes`.
To add a hard case: a subclass of `Case` of `case.py`, in `cases.py` or a module next to it, and
its class in `_EVERY` of `cases.py`.
"""
