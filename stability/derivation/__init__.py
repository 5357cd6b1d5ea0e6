"""Exact formulas and conditions.

Characteristic polynomials over Q, of the disk and of every height, Hurwitz conditions, formulas of
boundaries.  For any family `elimination` reads the graph, `signs` proves signs over a domain,
`deduction` puts both together, and `conditions` answers.  What is proved and not called is in
`notebooks/proofs`.
May import `bodies` and the floors below.
To add the polynomial of a family: its variables in `VARIABLES` of `characteristic.py`, then
`make derive`, which writes `bodies/disk_polynomials.json`.
To add a kind of proof: a method of `Domain` in `signs.py` that returns a sentence or None, and its
call in `_proof`.
"""
