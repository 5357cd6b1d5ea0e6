"""Exact statements about every body of revolution: polynomials, theorems, limits.

`graph` reads the general graph at one state, with the height's value and slopes as symbols;
`polynomials` derives from it; `rolling`, `spinning`, `tumbling`, `completeness` prove theorems, and
`pole` those about a vertical axis; `rim` rounds the rim of a coin; `painleve` bounds the slip;
`statements` makes the rows of the table.  May import `derivation/theorems`.
To add a theorem: a function that returns a `Theorem`, and its entry in `PROOFS` of `catalogue`.
"""
