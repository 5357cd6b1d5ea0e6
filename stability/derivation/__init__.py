"""Exact formulas and conditions.

Polynomials over Q, Hurwitz conditions, formulas of boundaries.  For any family `polynomials` reads
the graph, `signs` proves signs, and `deduction` puts both together.
May import `bodies`, `polynomials` and the floors below.  What is proved and not called is in
`notebooks/proofs`.
To add the stored polynomial of a family: `make derive`, which writes `bodies/disk_polynomials.json`
by `notebooks/proofs/stored.py`.
To add a kind of proof: a method of `Domain` in `signs.py`, and its call in `_proof`.
"""
