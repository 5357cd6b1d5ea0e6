"""Routes to eigenvalues, compared.

To add a route: a subclass of `Route` in `routes.py`, listed in `measure.py`.
To add a hard case: a subclass of `Case` in `cases.py`, listed in `CASES`.
"""
