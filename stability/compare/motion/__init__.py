"""Integrators, compared.

To add a driver: a subclass of `Driver` in `drivers.py`, listed in `DRIVERS`.
To add a hard case: a line of `MOTION_CASES` in `cases.py`; scenes are in
`reference_motions.json`.
"""
