"""Formulas and proofs by SymPy.

Characteristic polynomials over Q, Hurwitz conditions, formulas of boundaries, completeness, and
the theorems of `stability table theorems` (folder `theorems`).
May import `bodies` and the floors below.
To add the polynomial of a family: its variables in `VARIABLES` of `characteristic.py`, then
`make derive`, which writes `bodies/thin_disk/disk_polynomials.json`.
"""
