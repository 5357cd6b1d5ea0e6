"""Exact conditions of any family: its polynomial over Q, signs with proofs, members as witnesses.

`elimination` reads the graph, `signs` proves signs over a domain, `deduction` puts both together.
May import `systems` and the floors below.
To add a kind of proof: a method of `Domain` in `signs.py` that returns a sentence or None, and its
call in `_proof`.
"""
