"""Exact formulas and conditions.

Characteristic polynomials over Q, of the disk and of every height, Hurwitz conditions, formulas of
boundaries.  What is proved and not called is in `notebooks/proofs`.
May import `bodies` and the floors below.
To add the polynomial of a family: its variables in `VARIABLES` of `characteristic.py`, then
`make derive`, which writes `bodies/disk_polynomials.json`.
"""
